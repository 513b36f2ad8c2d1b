// Draws against densities by chi-square. Seed 2015; false-alarm rate 1e-3 for the file, shared by Sidak's rule.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "support/chi_square.h"
#include "support/quadrature.h"
#include "support/scale.h"
#include "support/seed.h"
#include "tress/adaptive/mixture.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr double pi = std::numbers::pi;
constexpr int bins = 200;
const int draws = test::scaled(200000);
constexpr std::size_t tests_in_file = 27;

template <class Sample, class Density>
double p_value(std::uint64_t key, Sample&& sample, Density&& density) {
  RandomStream random(test::seed(2015), key);
  std::vector<double> counts(bins), expected(bins);
  for (int i = 0; i < draws; ++i) {
    const double at = (sample(random.next()) + pi) / (2 * pi) * bins;
    counts[static_cast<std::size_t>(std::clamp(at, 0.0, bins - 1.0))] += 1;
  }
  double sum = 0;
  for (int i = 0; i < bins; ++i) {
    sum += expected[static_cast<std::size_t>(i)] =
        test::integrate([&](double x) { return density(static_cast<float>(x)); }, -pi + 2 * pi * i / bins,
                        -pi + 2 * pi * (i + 1) / bins, 40);
  }
  EXPECT_NEAR(sum, 1, 1e-4);
  for (double& e : expected) e *= draws / sum;
  return test::chi_square(counts, expected).p_value;
}

TEST(MixtureSampling, SkewedComponentsFollowTheirDensity) {
  const float scales[] = {0.02f, 0.06f, 0.17f, 0.3f, 0.5f};
  std::uint64_t key = 0;
  for (const float left : scales) {
    for (const float right : scales) {
      const SkewLogistic shape{-2.0f + 0.2f * static_cast<float>(key), left, right};
      const double p =
          p_value(key++, [&](float u) { return shape.sample(u); }, [&](float x) { return shape.density(x); });
      EXPECT_GT(p, test::sidak_level(1e-3, tests_in_file)) << left << " " << right;
    }
  }
}

TEST(MixtureSampling, BroadSymmetricComponentFollowsItsDensity) {
  const SkewLogistic shape{1.0f, 5.0f, 5.0f};
  const double p = p_value(100, [&](float u) { return shape.sample(u); }, [&](float x) { return shape.density(x); });
  EXPECT_GT(p, test::sidak_level(1e-3, tests_in_file));
}

TEST(MixtureSampling, ProposalIsWhatIsDrawn) {
  Mixture mixture;
  mixture.component_count = 3;
  mixture.components[0] = {{0.4f, 0.1f, 0.3f}, 0.3f};
  mixture.components[1] = {{3.1f, 0.05f, 0.03f}, 0.2f};
  mixture.components[2] = {{-1.0f, 0.5f, 0.2f}, 0.01f};
  mixture.uniform_weight = 0.1f;
  const double p = p_value(
      101, [&](float u) { return mixture.sample(u, 0.05f); },
      [&](float x) { return mixture.proposal_density(x, 0.05f); });
  EXPECT_GT(p, test::sidak_level(1e-3, tests_in_file));
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
