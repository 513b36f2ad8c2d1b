#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "tress/adaptive/ribbon.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr double largest_scale = 1e12;
constexpr float least_decay = 1e-30f;
constexpr double first_rate = Ribbon::decay_rates[0], second_rate = Ribbon::decay_rates[1];

/// ln of the second decay over ln of the first, for the gamma law where l = ln(1 + first_rate scale). It falls from the
/// ratio of the rates at 0 towards 1.
double ratio_of(double l) { return std::log1p(second_rate / first_rate * std::expm1(l)) / l; }

/// Returns the l with this ratio_of(), by halving a range of ln l; the nearest end of the range if none has it.
double logarithm_of(double ratio) {
  double low = std::log(std::log1p(first_rate * static_cast<double>(GammaDecay::least_scale)));
  double high = std::log(std::log1p(first_rate * largest_scale));
  for (int halving = 0; halving < 50; ++halving) {
    const double middle = 0.5 * (low + high);
    (ratio_of(std::exp(middle)) > ratio ? low : high) = middle;
  }
  return std::exp(0.5 * (low + high));
}

}  // namespace

GammaDecay GammaDecay::from(const std::array<float, 2>& decays) {
  const double first = -std::log(static_cast<double>(std::clamp(decays[0], least_decay, 1.0f)));
  const double second = -std::log(static_cast<double>(std::clamp(decays[1], least_decay, 1.0f)));
  if (!(first > 0)) return {};
  const double l = logarithm_of(second / first);
  return {static_cast<float>(first / l), static_cast<float>(std::expm1(l) / first_rate)};
}

float GammaDecay::at(float rate) const {
  if (!(rate > 0)) return 1;
  return std::exp(-shape * std::log1p(scale * std::min(rate, std::numeric_limits<float>::max())));
}

}  // namespace tress::inline v0_2::adaptive
