// One ray through a circular cross-section, in closed form: what near-field models of circular fibers are made of.
#pragma once

#include <glm/vec3.hpp>

namespace tress::fiber {

/// Ray of known inclination theta with offset h in [-1, 1] over the radius, towards rising azimuth: it meets the circle
/// where the normal is gamma = asin h further than the ray. Plain data.
struct CircleRay {
  CircleRay(float eta, float theta, float h);

  /// Where the light of order p leaves, relative to the known azimuth: 2 gamma - 2 p gamma_t + p pi. Radians, any turn.
  float exit_azimuth(int p) const;
  /// e^(-sigma_a path), of one way through. sigma_a per radius.
  glm::vec3 transmittance(const glm::vec3& sigma_a) const;

  float reflectance;  ///< F, exact in three dimensions; the same at every meeting with the surface
  float gamma, gamma_t;
  float path;  ///< in three dimensions, radii
};

/// The circle that stands for an ellipse of this minor over major semi-axis: of the same mean projected width. Its
/// radius over the major semi-axis, by which sigma_a per major semi-axis becomes sigma_a per radius.
float circle_radius(float eccentricity);

}  // namespace tress::fiber
