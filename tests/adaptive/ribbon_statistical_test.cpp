// What a ribbon draws is distributed as its density, and the test of a row by fresh draws has no bias.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "adaptive/learn_samples.h"
#include "adaptive/random_ribbons.h"
#include "adaptive/sampled_targets.h"
#include "convergence/held_out_test.h"
#include "support/chi_square.h"
#include "support/scale.h"
#include "support/seed.h"
#include "tress/adaptive/ribbon.h"

namespace tress::inline v0_2::adaptive {
namespace {

// Seed 21; 12 tests of a family with a false-alarm rate of 1e-4 together. The distribution functions, which are checked
// against integrals of the density by ribbon_test.cpp, must make draws uniform in 32 x 16 cells.
TEST(RibbonStatistical, DrawsFromItsDensity) {
  const double level = test::sidak_level(1e-4, 12);
  constexpr std::size_t us = 32, vs = 16;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    const Ribbon ribbon = random_ribbon(seed, seed >= 8);
    const int draws = test::scaled(100000);
    std::vector<double> counts(us * vs, 0.0), expected(us * vs, static_cast<double>(draws) / (us * vs));
    RandomStream random(test::seed(21), seed);
    const auto cell = [](float share, std::size_t cells) {
      return std::min(static_cast<std::size_t>(share * static_cast<float>(cells)), cells - 1);
    };
    for (int i = 0; i < draws; ++i) {
      const float u = random.next();
      const auto [x, t] = ribbon.sample(u, random.next());
      const auto [below, share] = ribbon.cdf(x, t);
      ++counts[cell(below, us) * vs + cell(share, vs)];
    }
    EXPECT_GT(test::chi_square(counts, expected).p_value, level) << "ribbon " << seed;
  }
}

RibbonRow row_of(const Ribbon& ribbon, float mass) { return RibbonRow(std::vector<RibbonRow::Part>{{ribbon, mass}}); }

// Streams by seed 22; two z-tests at 1e-4 together, and the deviation that the test states against the spread of its
// values over 400 tests, whose own relative error is 1/sqrt(800) = 0.035: right within a quarter.
TEST(HeldOutTestStatistical, HasNoBiasAndKnowsItsDeviation) {
  const double level = test::sidak_level(1e-4, 2);
  const RibbonRow row = row_of(random_ribbon(8), 0.5f);
  const SliceDescription slice;
  for (const bool same : {true, false}) {
    const PathTarget target = same ? target_of(row.ribbon(0), 0.5f) : target_of(random_ribbon(6), 0.45f);
    const SampledTest truth =
        same ? SampledTest{} : test_samples(target, slice, 0, 0, row, test::seed(22) + 1000, test::scaled(1 << 20));
    test::SampleMean values, deviations, squares;
    for (int i = 0; i < test::scaled(400); ++i) {
      const SampledTest test =
          test_samples(target, slice, 0, 0, row, test::seed(22) + static_cast<std::uint64_t>(i), 2048);
      values.add(test.chi2);
      deviations.add(test.deviation * test.deviation);
      squares.add((test.chi2 - truth.chi2) * (test.chi2 - truth.chi2));
    }
    const double error = std::hypot(values.standard_error(), truth.deviation);
    EXPECT_GT(test::z_test(values.mean(), truth.chi2, error), level)
        << values.mean() << " +- " << error << ", not " << truth.chi2;
    const double ratio = std::sqrt(squares.mean() / deviations.mean());
    EXPECT_NEAR(ratio, 1, 0.25 * test::widened(400)) << "stated " << std::sqrt(deviations.mean());
  }
}

// The same of few paths, 512, which leave several parts with a weight that they share: seed 24, 600 tests, whose spread
// is known to 1/sqrt(1200) = 0.03. Where the row is right T is 0 on the mean, a z-test at a level of half of 1e-4;
// stated within a fifth, so that a rule may go by it. Of its own sets alone a cell's variance makes the deviation of a
// row that is wrong 1.25 times as large.
TEST(HeldOutTestStatistical, KnowsItsDeviationByFewPathsOfSeveralExits) {
  const double level = test::sidak_level(1e-4, 2);
  const RibbonRow row(
      std::vector<RibbonRow::Part>{{random_ribbon(8), 0.2f}, {random_ribbon(11), 0.35f}, {random_ribbon(14), 0.1f}});
  for (const bool same : {true, false}) {
    const std::array<Ribbon, 3> from{same ? row.ribbon(0) : random_ribbon(6), row.ribbon(1), row.ribbon(2)};
    const PathTarget target(3, [&from](RandomStream& random, std::vector<SampledExit>& out) {
      const float bright = 2 * random.next();
      const std::array<float, 3> weight{0.2f * bright, 0.7f - 0.35f * bright, random.next() < 0.25f ? 0.4f : 0.0f};
      for (std::uint32_t p = 0; p < 3; ++p) {
        const float u = random.next();
        const auto [x, t] = from[p].sample(u, random.next());
        if (weight[p] > 0) out.push_back({x, t, p, weight[p], 0});
      }
    });
    test::SampleMean values, squares, deviations;
    for (int i = 0; i < test::scaled(600); ++i) {
      const SampledTest test =
          test_samples(target, SliceDescription{}, 0, 0, row, test::seed(24) + static_cast<std::uint64_t>(i), 512);
      values.add(test.chi2);
      squares.add(test.chi2 * test.chi2);
      deviations.add(test.deviation * test.deviation);
    }
    if (same) {
      EXPECT_GT(test::z_test(values.mean(), 0, values.standard_error()), level) << values.mean();
    }
    const double spread = squares.mean() - values.mean() * values.mean();
    EXPECT_NEAR(std::sqrt(spread / deviations.mean()), 1, 0.2 * test::widened(600));
  }
}

// Seeds from 23 on: 60 rows of random ribbons. What passes by 3.1 deviations may be above epsilon by the chance of a
// normal law, 0.001 a test, of four tests a row: more than 3 of 60 have a chance below 1e-4.
TEST(SampledLearnerStatistical, RowsPassFalselyAsSeldomAsTheirTestSays) {
  const SliceDescription slice;
  int above = 0, passed = 0;
  const int rows = test::scaled(60);
  for (int i = 0; i < rows; ++i) {
    const PathTarget target = target_of(random_ribbon(test::seed(23) + static_cast<std::uint64_t>(i)));
    SampledLimits limits;
    const SampledRow learned = learn_samples(target, slice, 0, 0, limits);
    if (learned.verdict != SampledRow::Verdict::converged) continue;
    ++passed;
    above += test_samples(target, slice, 0, 0, learned.row, 0, 1 << 15).chi2 > limits.epsilon ? 1 : 0;
  }
  EXPECT_GT(passed, rows / 2);
  EXPECT_LE(above, 3);
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
