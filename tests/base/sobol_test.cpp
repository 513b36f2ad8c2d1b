#include "base/sobol.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace {

using tress::ScrambledSobol;

/// How many cells of a grid of `across` x `down` have exactly one of the first across * down points.
std::size_t cells_with_one(const ScrambledSobol& points, std::size_t d, std::size_t e, std::uint32_t across,
                           std::uint32_t down) {
  std::vector<int> count(across * down);
  for (std::uint32_t i = 0; i < across * down; ++i) {
    const ScrambledSobol::Point p = points.point(i);
    ++count[static_cast<std::uint32_t>(p[d] * static_cast<float>(across)) * down +
            static_cast<std::uint32_t>(p[e] * static_cast<float>(down))];
  }
  std::size_t with_one = 0;
  for (const int c : count) with_one += c == 1;
  return with_one;
}

TEST(ScrambledSobol, EveryDimensionIsStratifiedInEveryPrefix) {
  for (std::uint64_t key = 0; key < 20; ++key) {
    const ScrambledSobol points(key);
    for (std::size_t d = 0; d < ScrambledSobol::dimensions; ++d) {
      for (std::uint32_t n = 1; n <= 1024; n *= 4) EXPECT_EQ(cells_with_one(points, d, 0, n, 1), n) << key << ' ' << d;
    }
  }
}

TEST(ScrambledSobol, PointsInLanesAreTheSameBits) {
  for (const std::uint64_t key : {1ull, 0xfedcba9876543210ull}) {
    const ScrambledSobol points(key);
    for (const std::uint32_t first : {0u, 5u, 16u, 4093u, 0xffffff00u}) {
      for (const std::uint32_t count : {1u, 16u, 41u}) {
        std::vector<std::vector<float>> all(ScrambledSobol::dimensions, std::vector<float>(count));
        std::vector<float*> out;
        for (std::vector<float>& dimension : all) out.push_back(dimension.data());
        points.points(first, count, out);
        for (std::uint32_t i = 0; i < count; ++i) {
          for (std::size_t d = 0; d < all.size(); ++d) EXPECT_EQ(all[d][i], points.point(first + i)[d]) << first + i;
        }
      }
    }
  }
}

TEST(ScrambledSobol, TheFirstTwoDimensionsAreANet) {
  const ScrambledSobol points(7);
  for (std::uint32_t across = 1; across <= 256; across *= 2) {
    EXPECT_EQ(cells_with_one(points, 0, 1, across, 256 / across), 256u) << across;
  }
}

// Every dimension has another sequence: pairs fill the square, which 64 x 64 cells would not if two were alike.
TEST(ScrambledSobol, DimensionsAreDifferent) {
  const ScrambledSobol points(3);
  for (std::size_t d = 0; d < ScrambledSobol::dimensions; ++d) {
    for (std::size_t e = 0; e < d; ++e) {
      double covariance = 0;
      constexpr std::uint32_t n = 4096;
      for (std::uint32_t i = 0; i < n; ++i) {
        const ScrambledSobol::Point p = points.point(i);
        covariance += (static_cast<double>(p[d]) - 0.5) * (static_cast<double>(p[e]) - 0.5) / n;
      }
      // 5 standard deviations of as many independent pairs: 1/12 over the root of n.
      EXPECT_LT(std::abs(covariance), 5 / 12.0 / std::sqrt(n)) << d << ' ' << e;
    }
  }
}

// Over keys a point of any index is uniform: mean and variance within 5 standard errors (80 of them: 5e-5 over seeds).
TEST(ScrambledSobol, EveryPointIsUniformOverKeys) {
  constexpr int keys = 4096;
  for (const std::uint32_t index : {0u, 1u, 2u, 77u, 0xffffffffu}) {
    for (std::size_t d = 0; d < ScrambledSobol::dimensions; ++d) {
      double mean = 0, square = 0;
      for (int key = 0; key < keys; ++key) {
        const auto x = static_cast<double>(ScrambledSobol(static_cast<std::uint64_t>(key)).point(index)[d]) - 0.5;
        ASSERT_LT(x, 0.5);
        mean += x / keys;
        square += x * x / keys;
      }
      EXPECT_NEAR(mean, 0, 5 * std::sqrt(1 / 12.0 / keys)) << index << ' ' << d;
      EXPECT_NEAR(square, 1 / 12.0, 5 * std::sqrt(1 / 180.0 / keys)) << index << ' ' << d;
    }
  }
}

}  // namespace
