// What a knot table draws is distributed as its proposal density says.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include "references/knot_tables.h"
#include "support/chi_square.h"
#include "support/scale.h"
#include "support/seed.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr double pi = std::numbers::pi;

// Seed 11; 18 tests of a family with a false-alarm rate of 1e-4 together. Bins of a third of a cell, so that a draw
// that is uniform within its cell fails: 100,000 draws, in 384 bins at most.
TEST(KnotDensityStatistical, DrawsFromItsProposal) {
  const double level = test::sidak_level(1e-4, 18);
  for (const std::size_t count : {32u, 64u, 128u}) {
    for (std::uint64_t seed = 0; seed < 3; ++seed) {
      for (const float share : {0.0f, 0.05f}) {
        const KnotDensity table = rough_table(count, 0.6f, seed);
        const std::size_t bins = 3 * count;
        const int draws = test::scaled(100000);
        std::vector<double> counts(bins, 0.0), expected(bins);
        RandomStream random(test::seed(11), count, seed);
        for (int i = 0; i < draws; ++i) {
          const double x = table.sample(random.next(), share);
          ++counts[std::min(static_cast<std::size_t>((x + pi) / (2 * pi) * static_cast<double>(bins)), bins - 1)];
        }
        for (std::size_t b = 0; b < bins; ++b) {  // the density is a line within a bin: its middle is its mean
          const auto middle =
              static_cast<float>(-pi + 2 * pi * (static_cast<double>(b) + 0.5) / static_cast<double>(bins));
          expected[b] =
              draws * 2 * pi / static_cast<double>(bins) * static_cast<double>(table.proposal_density(middle, share));
        }
        EXPECT_GT(test::chi_square(counts, expected).p_value, level)
            << count << " knots, table " << seed << ", u " << share;
      }
    }
  }
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
