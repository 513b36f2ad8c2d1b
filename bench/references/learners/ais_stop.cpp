#include "references/learners/ais_stop.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tress::inline v0_2::adaptive {
namespace {

// The block of k changes that ends `back` blocks before the end: S_(jk,t)/k, and the empirical variance.
struct Block {
  double mean = 0, variance = 0;
};

Block block(std::span<const double> x, std::size_t k, std::size_t back) {
  const std::span<const double> values = x.subspan(x.size() - 1 - (back + 1) * k, k + 1);
  const auto n = static_cast<double>(k);
  Block result;
  result.mean = (values[k] - values[0]) / n;
  for (std::size_t i = 0; i < k; ++i) {
    const double off = values[i + 1] - values[i] - result.mean;
    result.variance += off * off / std::max(n - 1, 1.0);
  }
  return result;
}

double normal_cdf(double z) { return 0.5 * std::erfc(-z / std::numbers::sqrt2); }

}  // namespace

double ais_p_value(std::span<const double> x, std::size_t k, double epsilon, AisStop form) {
  if (k == 0 || x.size() < k + 1) return 1;
  const std::size_t blocks = std::min<std::size_t>((x.size() - 1) / k, 3);
  const double high = std::log1p(epsilon);
  const double low = form == AisStop::printed ? high : std::log1p(-epsilon);
  const Block last = block(x, k, 0);
  double nu_low = low, nu_high = high, variance = last.variance;
  if (blocks >= 2) {
    const Block before = block(x, k, 1);
    const double sum = before.variance + last.variance;
    const double share = sum > 0 ? before.variance / sum : 0;
    nu_low -= share * (before.mean - high);  // the largest over v of mu_l - share (S/k - v)
    nu_high -= share * (before.mean - low);  // the least
    if (blocks == 3) {
      const double first = block(x, k, 2).variance;
      if (first + before.variance > 0) variance += first * before.variance / (first + before.variance);
    }
  }
  const double scale = form == AisStop::printed ? variance : std::sqrt(variance);
  const double root = std::sqrt(static_cast<double>(k)) / std::max(scale, 1e-300);
  const double p = 1 - normal_cdf(root * (last.mean - nu_low)) + normal_cdf(root * (last.mean - nu_high));
  return std::clamp(p, 0.0, 1.0);
}

double ais_p_product(std::span<const double> x, std::size_t k, double epsilon, AisStop form) {
  double product = 1;
  for (std::size_t t = k; k > 0 && t < x.size(); t += k) product *= ais_p_value(x.first(t + 1), k, epsilon, form);
  return product;
}

}  // namespace tress::inline v0_2::adaptive
