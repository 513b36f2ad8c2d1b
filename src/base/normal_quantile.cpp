#include "base/normal_quantile.h"

#include <algorithm>

namespace tress::inline v0_2 {

float normal_quantile(float u) {
  const float x = std::clamp(2 * u - 1, -0.99999994f, 0.99999994f);
  return normal_beyond(x, -std::log((1 - x) * (1 + x)));
}

}  // namespace tress::inline v0_2
