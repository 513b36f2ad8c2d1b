// Grooms that need no file: hair on a head, a lock, a ball of fur, single fibers.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "scene/model/scene.h"

namespace tress::scene {

/// A number that shapes a kind of groom, and its default.
struct ShapeParameter {
  std::string key;
  double low, high, usual;
};

struct GroomRecipe {
  std::string kind;                           ///< one of generated_groom_kinds()
  std::optional<std::uint32_t> strands = {};  ///< unset: usual_strands(kind)
  std::uint64_t seed = 0;
  std::map<std::string, double> shape = {};  ///< by key of shape_parameters(kind), in range; if absent, the default
  double radius_cm = 0.004;                  ///< before the taper
};

/// "curly_lock", "straight", "wavy", "curly", "layered", "curtain", "fur_ball", "single_fiber".
const std::vector<std::string>& generated_groom_kinds();

/// The parameters of a known kind.
const std::vector<ShapeParameter>& shape_parameters(const std::string& kind);
std::uint32_t usual_strands(const std::string& kind);

/// The number of points per strand for the recipe; kind and shape must be in range.
std::uint32_t points_per_strand(const GroomRecipe& recipe);

/// Makes a groom: z up, centimetres. The same recipe gives the same points. Radii are those of the recipe along the
/// whole strand, except for the finer undercoat of fur. Roots have uv in [0, 1]: around the origin longitude (+y at
/// 0.5, -x to its right) and latitude, of hanging strands x and y of the box of their roots. kind must be known.
/// Lengths are measured along the fall: waves and curls take more hair.
/// - curly_lock: helices of varying phase, clumped in one lock that hangs from z = 0.
/// - straight, wavy, curly: rooted on the scalp of a head of 9 cm around the origin, parted along x = 0, with the face
///   towards +y (a camera at -y sees the back of the head). They fall under gravity along the head and are clumped
///   towards the tips.
/// - layered: on the same head, swept back and cut in layers. Strands form strings in wisps, and wisps form locks that
///   wave together, with some strays; with curl_diameter_cm each wisp is a curl of its own.
/// - curtain: from roots at z = 0, width_cm along x and a quarter of that along y (0.5 to 3 cm); locks hang and wave
///   together, or are curls.
/// - fur_ball: a ball around the origin, combed down and around, with a shorter and finer undercoat under guard hairs.
/// - single_fiber: hangs from z = 0; several of them are side by side along x, 0.1 cm apart.
Groom generate_groom(const GroomRecipe& recipe);

}  // namespace tress::scene
