#include <algorithm>
#include <cmath>

#include "tress/adaptive/ribbon.h"

namespace tress::adaptive {
namespace {

constexpr double largest_scale = 1e12;
constexpr float least_decay = 1e-30f;
constexpr double first_rate = Ribbon::decay_rates[0], second_rate = Ribbon::decay_rates[1];

/// ln of the second decay over ln of the first, for the gamma law of this scale: from the ratio of the rates at 0 it
/// falls towards 1.
double ratio_of(double scale) { return std::log1p(second_rate * scale) / std::log1p(first_rate * scale); }

}  // namespace

GammaDecay GammaDecay::from(const std::array<float, 2>& decays) {
  const double first = -std::log(static_cast<double>(std::clamp(decays[0], least_decay, 1.0f)));
  const double second = -std::log(static_cast<double>(std::clamp(decays[1], least_decay, 1.0f)));
  if (!(first > 0)) return {};
  const double ratio = second / first;
  double low = std::log(static_cast<double>(least_scale)), high = std::log(largest_scale);
  if (ratio >= ratio_of(std::exp(low))) {
    high = low;
  } else if (ratio <= ratio_of(std::exp(high))) {
    low = high;
  }
  // ratio_of falls with the logarithm of the scale: the secant, kept within its bracket (Illinois).
  double at_low = ratio_of(std::exp(low)) - ratio, at_high = ratio_of(std::exp(high)) - ratio, middle = low;
  for (int i = 0, side = 0; i < 60 && high - low > 1e-7; ++i) {
    middle = (low * at_high - high * at_low) / (at_high - at_low);
    const double at = ratio_of(std::exp(middle)) - ratio;
    if (std::abs(at) < 1e-9) break;
    if (at > 0) {
      low = middle, at_low = at;
      if (side == 1) at_high *= 0.5;
      side = 1;
    } else {
      high = middle, at_high = at;
      if (side == -1) at_low *= 0.5;
      side = -1;
    }
  }
  const double scale = std::exp(middle);
  return {static_cast<float>(first / std::log1p(first_rate * scale)), static_cast<float>(scale)};
}

float GammaDecay::at(float rate) const { return std::exp(-shape * std::log1p(scale * rate)); }

}  // namespace tress::adaptive
