// The share of the light at a knot of a ribbon that a color leaves.
#pragma once

#include <array>
#include <cstddef>
#include <glm/vec3.hpp>

#include "tress/adaptive/ribbon.h"

namespace tress::inline v0_2::fiber {

/// GammaDecay::at() of the three channels of one sigma_a (1 / fiber radius), from a table. The logarithm of the result
/// over that of the first decay depends only on the ratio of the logarithms of both decays. A packed row has 256 such
/// ratios, at equal steps, and the table has an entry for each; it is linear between them. Immutable; any thread.
class ColoredDecays {
 public:
  explicit ColoredDecays(const glm::vec3& sigma_a);

  /// GammaDecay::from() of a knot of a packed row, from the table.
  static adaptive::GammaDecay law(const std::array<float, 2>& decays);

  static constexpr std::size_t steps = 255;
  static constexpr float most_ratio = adaptive::Ribbon::decay_rates[1] / adaptive::Ribbon::decay_rates[0];
  /// By channel and step: -ln of what the color leaves over -ln of the first decay, at the ratio
  /// 1 + (most_ratio - 1) step / steps.
  using Tables = std::array<std::array<float, steps + 1>, 3>;
  const Tables& by_ratio() const { return by_ratio_; }

 private:
  Tables by_ratio_;
};

}  // namespace tress::inline v0_2::fiber
