// Directions between the world and a fiber's frame (ESTIMATOR.md, E5).
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "geometry/fiber_scene.h"
#include "tress/fiber/lobes.h"

namespace tress::integrate {

/// A direction in the fiber's frame and the cosine of its inclination, which the change of measure needs:
/// d(solid angle) = cos_theta dtheta dphi.
struct LocalDirection {
  fiber::FiberDirection direction;
  float cos_theta;  ///< >= 0
};

/// direction: unit, pointing away from the fiber.
inline LocalDirection to_local(const geometry::Hit& hit, const glm::vec3& direction) {
  const float along_u = glm::dot(direction, hit.u);
  const float along_v = glm::dot(direction, hit.v);
  const float along_w = glm::dot(direction, hit.w);
  float phi = std::atan2(along_w, along_v);
  if (phi >= std::numbers::pi_v<float>) phi = -std::numbers::pi_v<float>;
  return {{std::asin(std::clamp(along_u, -1.0f, 1.0f)), phi}, std::sqrt(along_v * along_v + along_w * along_w)};
}

inline float cos_theta(const fiber::FiberDirection& direction) { return std::max(0.0f, std::cos(direction.theta)); }

inline glm::vec3 to_world(const geometry::Hit& hit, const fiber::FiberDirection& direction) {
  const float cosine = cos_theta(direction);
  return glm::normalize(std::sin(direction.theta) * hit.u + cosine * std::cos(direction.phi) * hit.v +
                        cosine * std::sin(direction.phi) * hit.w);
}

}  // namespace tress::integrate
