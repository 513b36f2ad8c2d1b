// Statistical tests of samplers: Pearson's chi-square on bins and a z-test of a mean, Sidak-corrected.
//
// A family of n tests at family level alpha (the chance that correct code fails any of them) compares each p-value
// with sidak_level(alpha, n). With fixed seeds a test either always passes or always fails; the level is the
// chance, over the choice of the seed, that a correct sampler would have failed.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <vector>

namespace tress::test {

/// Upper tail Q(a, x) of the regularised incomplete gamma function, a > 0, x >= 0 (Numerical Recipes 6.2). ~1e-12.
inline double upper_gamma(double a, double x) {
  if (x <= 0) return 1;
  const double front = std::exp(-x + a * std::log(x) - std::lgamma(a));
  if (x < a + 1) {
    double term = 1 / a, sum = term;
    for (int n = 1; n < 10000 && term > sum * 1e-15; ++n) sum += term *= x / (a + n);
    return 1 - front * sum;
  }
  double b = x + 1 - a, c = 1e300, d = 1 / b, h = d;
  for (int i = 1; i < 10000; ++i) {
    const double an = -i * (i - a);
    b += 2;
    d = 1 / std::max(std::abs(an * d + b), 1e-300) * (an * d + b < 0 ? -1 : 1);
    c = b + an / c;
    const double step = d * c;
    h *= step;
    if (std::abs(step - 1) < 1e-15) break;
  }
  return front * h;
}

/// Level of each of `tests` independent tests so that all together have the false-alarm rate `family_level`.
inline double sidak_level(double family_level, std::size_t tests) {
  return -std::expm1(std::log1p(-family_level) / static_cast<double>(std::max<std::size_t>(tests, 1)));
}

struct ChiSquare {
  double statistic = 0;
  int degrees_of_freedom = 0;
  double p_value = 1;  ///< 0 if anything was counted where nothing is expected
};

/// counts: samples per bin. expected: expected counts, same size, summing to the number of samples (bins cover the
/// whole domain). Bins are pooled in ascending order of expectation until each pool expects `pool` or more.
inline ChiSquare chi_square(const std::vector<double>& counts, const std::vector<double>& expected, double pool = 5) {
  std::vector<std::size_t> order(counts.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return expected[a] < expected[b]; });
  ChiSquare result;
  double pooled_count = 0, pooled_expected = 0;
  int cells = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    pooled_count += counts[order[i]];
    pooled_expected += expected[order[i]];
    if (pooled_expected < pool && i + 1 < order.size()) continue;
    if (pooled_expected <= 0) {
      if (pooled_count > 0) result.p_value = 0;
    } else {
      const double d = pooled_count - pooled_expected;
      result.statistic += d * d / pooled_expected;
      ++cells;
    }
    pooled_count = pooled_expected = 0;
  }
  result.degrees_of_freedom = cells - 1;
  if (result.p_value > 0 && cells > 1) {
    result.p_value = upper_gamma(0.5 * result.degrees_of_freedom, 0.5 * result.statistic);
  }
  return result;
}

/// Running mean and its standard error (Welford).
class SampleMean {
 public:
  void add(double x) {
    ++count_;
    const double d = x - mean_;
    mean_ += d / count_;
    sum_squares_ += d * (x - mean_);
  }
  double mean() const { return mean_; }
  double standard_error() const { return count_ > 1 ? std::sqrt(sum_squares_ / (count_ * (count_ - 1))) : 0; }

 private:
  double count_ = 0, mean_ = 0, sum_squares_ = 0;
};

/// Two-sided p-value of `value` against a normal of mean `expected` and standard deviation `standard_error`.
inline double z_test(double value, double expected, double standard_error) {
  const double d = std::abs(value - expected);
  if (d == 0) return 1;
  return standard_error > 0 ? std::erfc(d / standard_error / std::sqrt(2.0)) : 0;
}

}  // namespace tress::test
