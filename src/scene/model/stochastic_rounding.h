// Rounding that keeps the mean: E over u of the rounded value is the value.
#pragma once

#include <cmath>
#include <cstdint>

namespace tress::scene {

/// floor(x + u), u uniform in [0, 1): the whole number below or above, of mean x. Within [low, high] where x is, for
/// whole low and high.
inline std::int64_t round_stochastically(double x, double u) { return static_cast<std::int64_t>(std::floor(x + u)); }

/// k with ratio^k the power below or above x > 0, ratio > 1, of mean ratio^k = x. The standard deviation is at most
/// (ratio - 1)/(2 sqrt(ratio)) of x.
inline std::int64_t round_to_power(double x, double ratio, double u) {
  const double k = std::floor(std::log(x) / std::log(ratio));
  const double below = std::pow(ratio, k);
  return static_cast<std::int64_t>(k) + (u * (below * ratio - below) < x - below ? 1 : 0);
}

}  // namespace tress::scene
