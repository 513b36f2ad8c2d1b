// Natural hair colors by name.
#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tress/fiber/parameters.h"

namespace tress::scene {

/// A color of hair by its pigments.
struct HairColor {
  std::string_view name;
  float eumelanin, pheomelanin;  ///< concentrations for sigma_a_from_melanin()
  glm::vec3 other{0.0f};         ///< absorption of other pigments, per major semi-axis
};

/// Chosen so that a dense lock in even light has the color of the name: brown 0.08, 0.04, 0.02, blond 0.43, 0.31, 0.18
/// (linear, bench/figures/colors.py --lock). The pheomelanin of the literature gives at most tan or orange-brown hair,
/// so red hair is given by the absorption of locks with the colors 0.25, 0.07, 0.024 and 0.10, 0.03, 0.012
/// (sigma_a_of_lock()). Grey hair is a mix of strands with and without pigment; from afar it looks like a thin neutral
/// pigment.
constexpr std::array hair_colors{HairColor{"black", 8, 0},
                                 HairColor{"dark brown", 1.3f, 0},
                                 HairColor{"brown", 0.5f, 0.05f},
                                 HairColor{"light brown", 0.15f, 0.04f},
                                 HairColor{"auburn", 0, 0, {0.156f, 0.532f, 1.289f}},
                                 HairColor{"red", 0, 0, {0.048f, 0.23f, 0.66f}},
                                 HairColor{"blond", 0.02f, 0.05f},
                                 HairColor{"platinum", 0.01f, 0.008f},
                                 HairColor{"white", 0, 0},
                                 HairColor{"grey", 0, 0, {0.055f, 0.058f, 0.066f}}};

/// The names "black", ..., "white", "grey".
inline std::vector<std::string> hair_color_names() {
  std::vector<std::string> names;
  for (const HairColor& color : hair_colors) names.emplace_back(color.name);
  return names;
}

}  // namespace tress::scene
