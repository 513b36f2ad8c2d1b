#include "models/rough/colored_decays.h"

#include <algorithm>
#include <cmath>

namespace tress::inline v0_2::fiber {
namespace {

constexpr std::size_t steps = ColoredDecays::steps;

/// The laws with a first decay of 1/e, by the step of their ratio.
const std::array<adaptive::GammaDecay, steps + 1>& laws() {
  static const auto all = [] {
    std::array<adaptive::GammaDecay, steps + 1> made;
    for (std::size_t i = 0; i <= steps; ++i) {
      const float ratio = 1 + (ColoredDecays::most_ratio - 1) * static_cast<float>(i) / static_cast<float>(steps);
      made[i] = adaptive::GammaDecay::from({std::exp(-1.0f), std::exp(-ratio)});
    }
    return made;
  }();
  return all;
}

}  // namespace

adaptive::GammaDecay ColoredDecays::law(const std::array<float, 2>& decays) {
  constexpr float least = 1e-37f;
  const float first = -std::log(std::clamp(decays[0], least, 1.0f)),
              second = -std::log(std::clamp(decays[1], least, 1.0f));
  if (!(first > 0)) return {};
  const float step = (second / first - 1) / (most_ratio - 1) * static_cast<float>(steps);
  const adaptive::GammaDecay& unit =
      laws()[static_cast<std::size_t>(std::lround(std::clamp(step, 0.0f, static_cast<float>(steps))))];
  return {first * unit.shape, unit.scale};
}

ColoredDecays::ColoredDecays(const glm::vec3& sigma_a) {
  for (std::size_t c = 0; c < by_ratio_.size(); ++c) {
    const float rate = sigma_a[static_cast<int>(c)];
    for (std::size_t i = 0; i <= steps; ++i) by_ratio_[c][i] = laws()[i].shape * std::log1p(laws()[i].scale * rate);
  }
}

}  // namespace tress::inline v0_2::fiber
