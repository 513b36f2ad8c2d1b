// The azimuthal shape of traced rays, clear and under absorption: g of a node or of a vertex.
#pragma once

#include <glm/vec3.hpp>
#include <span>

#include "tress/adaptive/traced_nodes.h"

namespace tress::inline v0_2::fiber {

/// The rays of one lobe: mass `weight` leaves at `azimuth` in [-pi, pi), after the internal path `attribute` (in major
/// semi-axes), blurred by a wrapped Gaussian of standard deviation blur_rad in (0, pi/4]. A view: it owns nothing.
struct RayShape {
  std::span<const float> azimuth, weight, attribute;
  float blur_rad = 0.2f;
  bool sorted = false;  ///< azimuth ascends, so only rays near an azimuth are visited
};

inline RayShape shape_of(const adaptive::TracedNodes& nodes) {
  return {nodes.azimuth(), nodes.weight(), nodes.attribute(), nodes.blur_rad(), true};
}

/// A quantity for clear hair and for each color channel.
struct ClearAndAbsorbed {
  float clear = 0;
  glm::vec3 absorbed{0.0f};
};

/// Returns sum_j A_j and, per channel c, sum_j A_j exp(-sigma_a^c l_j).
ClearAndAbsorbed ray_mass(const RayShape& rays, const glm::vec3& sigma_a);

/// Returns sum_j A_j exp(-sigma_a^c l_j) G(x - Phi_j), 1/rad, of mass ray_mass(). x in [-pi, pi).
ClearAndAbsorbed ray_density(const RayShape& rays, const glm::vec3& sigma_a, float x);

/// Draws an azimuth with density ray_density / ray_mass of one channel of absorption `sigma_a`: a ray by u_ray, then
/// the blur by u_blur. u in [0, 1). `mass` > 0: the channel's ray_mass. Radians in [-pi, pi).
float draw_azimuth(const RayShape& rays, float sigma_a, float mass, float u_ray, float u_blur);

}  // namespace tress::inline v0_2::fiber
