// What sample() draws has the density that proposal_density() returns, by the masses of E1 in closed form. No chance in
// it: u runs through the midpoints of n equal cells, and inversion piece by piece puts all but a few of them where they
// belong.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include "properties/generators.h"
#include "support/mixture_formula.h"

namespace tress::inline v0_2::adaptive {
namespace {

using std::numbers::pi;

RC_GTEST_PROP(SkewLogistic, SamplesTheInverseOfItsCumulativeDensity, ()) {
  const Mixture fit = *common_mixture();
  const std::vector<std::uint32_t> drawn = *any_numbers(12, 1u << 24);
  for (const Component& part : fit.parts()) {
    const SkewLogistic& shape = part.shape;
    // mu + x is rounded to a float and wrapped, 1.2e-7 rad each near pi; times the largest density.
    const double rounding = 3e-7 * test::density(shape, shape.mu) + 1e-9;
    for (std::uint32_t k : drawn) {
      for (const std::uint32_t at : {k, k / 1000, (1u << 24) - 1 - k / 1000}) {
        const float u = static_cast<float>(at) * 0x1p-24f;
        const float azimuth = shape.sample(u);
        RC_ASSERT(azimuth >= -std::numbers::pi_v<float> && azimuth < std::numbers::pi_v<float>);
        const double x = std::remainder(static_cast<double>(azimuth) - shape.mu, 2 * pi);
        const double below = test::mass_below(shape, x);
        // At the antipode, where the circle is cut, rounding may step over the cut.
        const double error = std::min(std::abs(below - u), 1 - std::abs(below - u));
        RC_ASSERT(error <= rounding);
      }
    }
  }
}

constexpr int draws = 2048;

/// Largest difference, over 64 arcs from -pi, between the share of the draws there and the mass that `mass` returns.
template <class Fit, class Mass>
double discrepancy(const Fit& fit, float u_share, const Mass& mass) {
  std::vector<float> drawn;
  for (int i = 0; i < draws; ++i) drawn.push_back(fit.sample((static_cast<float>(i) + 0.5f) / draws, u_share));
  std::ranges::sort(drawn);
  double worst = 0;
  for (int i = 1; i < 64; ++i) {
    const double end = -pi + 2 * pi * i / 64;
    const auto below = std::ranges::lower_bound(drawn, end) - drawn.begin();
    worst = std::max(worst, std::abs(static_cast<double>(below) / draws - mass(end)));
  }
  return worst;
}

RC_GTEST_PROP(Mixture, SamplesItsProposalDensity, ()) {
  const Mixture fit = *common_mixture();
  const std::vector<std::uint32_t> choice = *any_numbers(1, 3);
  const float share = std::vector<float>{0.02f, 0.05f, 0.0f}[choice[0]];
  const double energy = fit.energy();
  const auto mass = [&](double end) {
    const double flat = (end + pi) / (2 * pi);
    if (!(energy > 0)) return flat;
    double sum = static_cast<double>(fit.uniform_weight) * flat;
    for (const Component& part : fit.parts()) {
      sum += static_cast<double>(part.weight) * test::mass_between(part.shape, -pi, end);
    }
    return (1 - share) * sum / energy + share * flat;
  };
  // An arc meets each of D + 2 pieces of u in at most two intervals, each of which errs by less than a cell of u; and
  // azimuths are rounded by 3e-7 rad, densities at most 63/rad.
  const double allowed = 2.0 * (fit.component_count + 2) / draws + 2e-5;
  RC_ASSERT(discrepancy(fit, share, mass) <= allowed);
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
