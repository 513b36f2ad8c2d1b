// The paper's fit: its own estimate of its objective is unbiased, and its proposal draws what it says.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "references/ais_targets.h"
#include "references/learners/ais.h"
#include "references/learners/ais_proposal.h"
#include "support/chi_square.h"
#include "support/seed.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double family_level = 1e-4;  // of each test here; streams 1 .. are fixed

// The threshold is 0, so that no fit ends because of the very draws that score it: estimate - truth has mean 0.
TEST(AisStatistical, TheObjectiveIsUnbiased) {
  const AisTarget target = tress::testing::two_lobes();
  std::vector<double> p_values;
  for (const auto distance : {AisDistance::l2, AisDistance::relative_entropy}) {
    for (const int d : {1, 3}) {
      tress::test::SampleMean difference;
      for (std::uint64_t i = 0; i < 300; ++i) {
        AisSettings settings;
        settings.components = d;
        settings.distance = distance;
        settings.threshold = 0;
        settings.iterations = 6;
        settings.samples = 64;
        const AisFit fit = fit_ais(target, RandomStream(tress::test::seed(1), i), settings);
        difference.add(fit.objective - tress::testing::relative_l2(target, fit.mixture));
      }
      p_values.push_back(tress::test::z_test(difference.mean(), 0, difference.standard_error()));
    }
  }
  for (const double p : p_values) EXPECT_GT(p, tress::test::sidak_level(family_level, p_values.size()));
}

TEST(AisStatistical, TheProposalDrawsItsDensity) {
  const AisParts parts{{{0.3, 0.12, 0.3}, {3.0, 0.4, 0.2}, {-1.4, 0.05, 0.5}}, {0.9, 0.4, 0.2}, 0.1};
  constexpr int bins = 100, samples = 200000, inside = 50;
  for (const AisBasis basis : {AisBasis::circular, AisBasis::line}) {
    const AisProposal proposal(parts, basis, 0.05);
    std::vector<double> counts(bins), expected(bins);
    RandomStream random(tress::test::seed(2));
    for (int i = 0; i < samples; ++i) {
      const double x = proposal.sample(static_cast<double>(random.next_bits() >> 11) * 0x1p-53);
      counts[static_cast<std::size_t>(std::min((x + pi) / (2 * pi) * bins, bins - 1.0))] += 1;
    }
    for (int i = 0; i < bins * inside; ++i) {
      const auto x = static_cast<float>(-pi + 2 * pi * (i + 0.5) / (bins * inside));
      expected[static_cast<std::size_t>(i / inside)] += samples * proposal.density(x) * 2 * pi / (bins * inside);
    }
    EXPECT_GT(tress::test::chi_square(counts, expected).p_value, tress::test::sidak_level(family_level, 2));
  }
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
