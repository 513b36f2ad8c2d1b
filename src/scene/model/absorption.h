// The absorption of a material's colors: by channel of Rec. 709, or in the bands of a spectral render (base/bands.h).
#pragma once

#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <string_view>

#include "tress/fiber/parameters.h"

namespace tress::scene {

/// Converts a value into the fiber's absorption, per major semi-axis.
using Absorption = std::function<glm::vec3(const glm::vec3& value, const fiber::FiberParameters& fiber)>;

/// Spectral or not, what a value is decides how it becomes an absorption. Pure; any thread.
class AbsorptionOf {
 public:
  explicit AbsorptionOf(bool spectral) : spectral_(spectral) {}

  /// Concentrations of eumelanin and pheomelanin, >= 0. The bands have the powers of the wavelength that fit measured
  /// melanin, -3.33 and -4.75 (Jacques 2013, "Optical properties of biological tissues"), through the green of
  /// fiber::sigma_a_from_melanin() at 550 nm.
  glm::vec3 melanin(float eumelanin, float pheomelanin) const;
  /// fiber::sigma_a_of_principled_melanin(), whose pigments are the same.
  glm::vec3 principled_melanin(float melanin, float redness) const;
  /// An absorption by channel. The bands keep the color of a path of one major semi-axis.
  glm::vec3 given(const glm::vec3& sigma_a) const;
  /// A natural color by name (hair_colors.h); empty for an unknown name.
  std::optional<glm::vec3> hair(std::string_view name) const;

  /// given() as a rule.
  Absorption of_given() const;
  /// The rule of colors, of which a rule for one channel is known, as of a lock: its bands are found one by one, so
  /// that the color comes out as it is.
  Absorption of_color(Absorption by_channel) const;
  Absorption of_lock() const;

 private:
  bool spectral_;
};

}  // namespace tress::scene
