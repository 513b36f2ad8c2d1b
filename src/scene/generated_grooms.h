// Grooms that need no file: a curly lock, a straight groom on a head, single fibers.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace tress::scene {

struct GroomRecipe {
  std::string kind;                      ///< one of generated_groom_kinds()
  std::optional<std::uint32_t> strands;  ///< unset: 5,513, 19,226, 1 by kind
  std::uint64_t seed = 0;
  std::optional<double> length_cm;  ///< unset: 24, 32, 10 by kind
  double radius_cm = 0.004;         ///< at the root; tips taper to a third, the single fiber does not
};

/// "curly_lock", "straight", "single_fiber".
const std::vector<std::string>& generated_groom_kinds();

/// z up, centimetres; the same recipe gives the same points. kind must be known.
/// curly_lock: helices of varying phase clumped in one lock that hangs from z = 0.
/// straight: rooted on the scalp of a head of 9 cm around the origin, parted along x = 0, face towards +y (a camera at
/// -y sees the back of the head), falling under gravity along the head, clumped towards the tips.
/// single_fiber: hangs from z = 0; more than one stand side by side along x, .1 cm apart.
Groom generate_groom(const GroomRecipe& recipe);

}  // namespace tress::scene
