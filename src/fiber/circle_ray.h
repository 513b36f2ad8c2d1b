// One ray through a circular cross-section in closed form, for near-field models of circular fibers.
#pragma once

#include <glm/vec3.hpp>

namespace tress::inline v0_2::fiber {

/// A ray of known inclination theta with offset h in [-1, 1] over the radius, towards rising azimuth. It meets the
/// circle where the normal's azimuth is larger than the ray's by gamma = asin h. Plain data.
struct CircleRay {
  CircleRay(float eta, float theta, float h);

  /// The azimuth at which light of order p leaves, relative to the known one: 2 gamma - 2 p gamma_t + p pi. Radians,
  /// any turn.
  float exit_azimuth(int p) const;
  /// e^(-sigma_a path) for one crossing. sigma_a per radius.
  glm::vec3 transmittance(const glm::vec3& sigma_a) const;

  float reflectance;  ///< F, exact in three dimensions; it is the same at every hit on the surface
  float gamma, gamma_t;
  float path;  ///< length of one crossing in three dimensions, in radii
};

/// The radius, over the major semi-axis, of the circle that stands for an ellipse of this minor over major semi-axis:
/// it has the same mean projected width. It converts sigma_a per major semi-axis to sigma_a per radius.
float circle_radius(float eccentricity);

}  // namespace tress::inline v0_2::fiber
