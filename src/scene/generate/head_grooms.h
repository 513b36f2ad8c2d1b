// The generators of hair whose roots are on a head.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "scene/generate/groom_kinds.h"

namespace tress::scene {

Groom head_groom(const GroomShape& shape);
Groom layered_hair(const GroomShape& shape);

/// A point of the scalp on the unit sphere, anywhere above the neck except on the face (+y). Multiplied by
/// head_semi_axes_cm() it lies on the head.
glm::vec3 scalp_point(RandomStream& random);
glm::vec3 head_semi_axes_cm();

/// Moves p (cm) out of the head, which is inflated by `clearance` cm.
glm::vec3 outside_head(const glm::vec3& p, float clearance);

/// Makes `count` equally spaced points of a strand that leaves the scalp along its normal, away from the parting, then
/// falls along the head and freely below it. Stiffness: the length in cm over which gravity turns it.
std::vector<glm::vec3> fall_from_scalp(const glm::vec3& on_scalp, float length_cm, float clearance, float stiffness,
                                       std::uint32_t count);

}  // namespace tress::scene
