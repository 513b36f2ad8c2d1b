#include "models/rough/colored_decays.h"

#include <cmath>

namespace tress::fiber {

ColoredDecays::ColoredDecays(const glm::vec3& sigma_a) {
  for (std::size_t i = 0; i <= steps; ++i) {
    const float ratio = 1 + (most_ratio - 1) * static_cast<float>(i) / static_cast<float>(steps);
    const adaptive::GammaDecay decay = adaptive::GammaDecay::from({std::exp(-1.0f), std::exp(-ratio)});
    for (std::size_t c = 0; c < 3; ++c)
      by_ratio_[c][i] = decay.shape * std::log1p(decay.scale * sigma_a[static_cast<int>(c)]);
  }
}

}  // namespace tress::fiber
