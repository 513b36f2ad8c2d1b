// A head to root hair on, and how hair falls from it.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "tress/base/random.h"

namespace tress::scene {

/// A point of the scalp on the unit sphere, everything above the neck but the face (+y); on the head after
/// multiplication by head_semi_axes_cm().
glm::vec3 scalp_point(RandomStream& random);
glm::vec3 head_semi_axes_cm();

/// Moves p (cm) out of the head inflated by `clearance` cm.
glm::vec3 outside_head(const glm::vec3& p, float clearance);

/// `count` points, equally far apart, of a strand that leaves the scalp along its normal, away from the parting, then
/// falls along the head and freely below it. Stiffness: the length in cm over which gravity turns it.
std::vector<glm::vec3> fall_from_scalp(const glm::vec3& on_scalp, float length_cm, float clearance, float stiffness,
                                       std::uint32_t count);

}  // namespace tress::scene
