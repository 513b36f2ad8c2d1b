// A knot table is the straight lines between its knots: its mass, its density and its inverse CDF agree exactly.
#include "references/learners/knot_density.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include "references/knot_tables.h"
#include "support/quadrature.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr double pi = std::numbers::pi;

TEST(KnotDensity, IntegratesToItsEnergy) {
  for (const std::size_t count : {32u, 64u, 128u}) {
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
      const KnotDensity table = rough_table(count, 0.7f, seed);
      EXPECT_FLOAT_EQ(table.energy(), 0.7f);
      // A panel is one cell, where the density is a straight line; a float's rounding of the azimuth is 2e-7 of the
      // circle, of densities up to 10 times the mean.
      const double mass = test::integrate([&](double x) { return table.density(static_cast<float>(x)); }, -pi, pi,
                                          static_cast<int>(count));
      EXPECT_NEAR(mass, 0.7, 1e-5) << count << " knots, seed " << seed;
    }
  }
}

TEST(KnotDensity, IsItsKnotsAndLinearBetweenThem) {
  const KnotDensity table = rough_table(32, 1, 3);
  const auto h = static_cast<float>(2 * pi / 32);
  for (std::size_t k = 0; k < 32; ++k) {
    const float from = table.knots()[k].density, to = table.knots()[(k + 1) % 32].density;
    const float at = -std::numbers::pi_v<float> + static_cast<float>(k) * h;
    // h/2 is exact to 2e-7; a slope is at most 10/h.
    EXPECT_NEAR(table.density(at + 0.5f * h), 0.5f * (from + to), 2e-5f) << k;
    EXPECT_NEAR(table.density(at + 0.25f * h), 0.75f * from + 0.25f * to, 2e-5f) << k;
    EXPECT_NEAR(table.density(at + 4 * std::numbers::pi_v<float> + 0.5f * h), 0.5f * (from + to), 2e-4f) << k;
  }
  EXPECT_NEAR(table.density(std::nextafter(std::numbers::pi_v<float>, 0.0f)), table.knots()[0].density, 2e-5f);
}

TEST(KnotDensity, SamplingInvertsItsDistribution) {
  for (const std::size_t count : {32u, 128u}) {
    const KnotDensity table = rough_table(count, 2, 5);
    for (int i = 0; i < 200; ++i) {
      const float u = (static_cast<float>(i) + 0.5f) / 200;
      const float x = table.sample(u, 0);
      double mass = 0;  // below x, cell by cell: trapezoids are exact
      const double h = 2 * pi / static_cast<double>(count);
      for (std::size_t k = 0; k < count; ++k) {
        const double from = -pi + h * static_cast<double>(k), to = std::min(from + h, static_cast<double>(x));
        if (to <= from) break;
        const double a = table.knots()[k].density, b = table.knots()[(k + 1) % count].density, t = (to - from) / h;
        mass += (to - from) * (a + 0.5 * t * (b - a));
      }
      // x is rounded to 2.4e-7, at densities up to 10.
      EXPECT_NEAR(mass / 2, u, 5e-6) << count << " knots, u " << u;
    }
  }
}

TEST(KnotDensity, ProposalKeepsItsUniformShareAndItsWeightIsBounded) {
  const KnotDensity table = rough_table(64, 0.3f, 7);
  const float share = 0.02f;
  double mass = 0, largest = 0;
  const int points = 64 * 16;
  for (int i = 0; i < points; ++i) {
    const auto x = static_cast<float>(-pi + 2 * pi * (i + 0.5) / points);
    const double q = table.proposal_density(x, share);
    EXPECT_GE(q, 0.999 * share / (2 * pi));
    mass += q * 2 * pi / points;
    largest = std::max(largest, table.density(x) / table.energy() / q);
  }
  EXPECT_NEAR(mass, 1, 1e-5);
  EXPECT_LE(largest, 1 / (1 - share) + 1e-5);
  EXPECT_GT(largest, 1);
}

TEST(KnotDensity, HasAnAnswerForEveryInput) {
  const auto on_circle = [](float x) { return x >= -std::numbers::pi_v<float> && x < std::numbers::pi_v<float>; };
  std::vector<Knot> spike(32);
  spike[0].density = 5;  // its hat reaches over the seam
  for (const KnotDensity& table :
       {KnotDensity(), KnotDensity(std::vector<Knot>(32)), KnotDensity(spike), rough_table(128, 1, 9)}) {
    for (const float share : {0.0f, 0.02f, 1.0f}) {
      for (const float u : {0.0f, 1e-30f, 0.25f, 0.5f, 0.75f, 0.99999994f}) {
        const float x = table.sample(u, share);
        EXPECT_TRUE(on_circle(x)) << u;
        if (share > 0) {
          EXPECT_GT(table.proposal_density(x, share), 0.0f);
        }
        EXPECT_GE(table.density(x), 0.0f);
      }
    }
  }
  EXPECT_EQ(KnotDensity().energy(), 0.0f);
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
