#include "convergence/held_out_test.h"

#include <algorithm>
#include <cmath>

namespace tress::adaptive {
namespace {

std::size_t cell_of(float share, std::size_t cells) {
  return std::min(static_cast<std::size_t>(share * static_cast<float>(cells)), cells - 1);
}

}  // namespace

HeldOutTest::HeldOutTest(const RibbonRow& row) {
  for (std::uint32_t p = 0; p < row.parts(); ++p) mass_ += static_cast<double>(row.mass(p));
  for (std::uint32_t p = 0; p < row.parts(); ++p) {
    ribbons_.push_back(row.ribbon(p));
    expected_.push_back(std::max(static_cast<double>(row.mass(p)), least_share * mass_) / cells);
  }
  for (std::vector<double>& of_set : observed_) of_set.assign(row.parts() * cells, 0.0);
}

void HeldOutTest::add(std::size_t set, std::span<const SampledExit> exits) {
  for (const SampledExit& exit : exits) {
    const auto [u, v] = ribbons_[exit.part].cdf(exit.azimuth, exit.height);
    observed_[set][exit.part * cells + cell_of(u, cells_u) * cells_v + cell_of(v, cells_v)] +=
        static_cast<double>(exit.weight);
  }
}

SampledTest HeldOutTest::result(std::uint32_t paths) const {
  // Of one cell, with the mean m over the sets and their variance v: the mean of the products of two sets is
  // m^2 - v/sets. Its variance is 4 m^2 v/sets + 2 v^2/(sets (sets - 1)) over the true m and v; that of sets - 1
  // degrees of freedom has a v^2 that is (sets + 1)/(sets - 1) too large, and an m^2 that is v/sets too large.
  constexpr double n = sets;
  double sum = 0, variance = 0;
  for (std::size_t cell = 0; cell < observed_[0].size(); ++cell) {
    const double expected = expected_[cell / cells];
    if (!(expected > 0)) continue;
    double mean = 0, squares = 0;
    for (const std::vector<double>& of_set : observed_) mean += (of_set[cell] / paths - expected) / n;
    for (const std::vector<double>& of_set : observed_) {
      const double d = of_set[cell] / paths - expected - mean;
      squares += d * d;
    }
    const double v = squares / (n - 1), of_mean = v / n, per_mass = 1 / (expected * mass_);
    const double square_of_variance = v * v * (n - 1) / (n + 1);
    sum += (mean * mean - of_mean) * per_mass;
    variance += (4 * std::max(mean * mean - of_mean, 0.0) * of_mean + 2 * square_of_variance / (n * (n - 1))) *
                per_mass * per_mass;
  }
  return {sum, std::sqrt(variance)};
}

}  // namespace tress::adaptive
