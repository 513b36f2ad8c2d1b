// Knots fitted to traced nodes: the error that is reported is the error that is there, the mass is that of g, and the
// path moments of the knots give the light of a color.
#include "references/learners/fit_knots.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "adaptive/toy_target.h"
#include "tress/adaptive/traced_nodes.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr double pi = std::numbers::pi;
constexpr int fine = 4096;

/// A caustic and a broad part of other lengths, both with a spread of their own.
TracedNodes nodes_of(float blur_rad, std::uint64_t seed = 1) {
  RandomStream random(seed);
  std::vector<TracedRay> rays;
  const float turn = 6 * random.next();
  for (int i = 0; i < 256; ++i) {
    const float t = (static_cast<float>(i) + 0.5f) / 256;
    rays.push_back({turn + 1.2f * t * t, 0.5f / 256, 2.0f + t});
    rays.push_back({turn + 2.5f - 1.5f * std::sqrt(t), 0.2f / 256, 4.0f - 0.5f * t * t});
  }
  return TracedNodes(rays, blur_rad);
}

double true_objective(const KnotDensity& table, const TracedNodes& nodes) {
  double sum = 0;
  for (int i = 0; i < fine; ++i) {
    const auto x = static_cast<float>(-pi + 2 * pi * i / fine);
    const double r = static_cast<double>(nodes.density(x)) - static_cast<double>(table.density(x));
    sum += r * r * 2 * pi / fine;
  }
  return sum / static_cast<double>(nodes.variation());
}

// Boole's rule on four points a cell is exact for the square of what a parabola and a line differ by. At up to two
// blurs a knot, where g is more than that in a cell, it was within 20 % of the error on 6,000 rows of hair.
TEST(FitKnots, ReportsTheErrorThatIsThere) {
  for (const float blur : {0.07f, 0.1f, 0.15f, 0.2f, 0.3f, 0.45f}) {
    for (const double epsilon : {0.01, 0.001}) {
      for (std::uint64_t seed = 0; seed < 5; ++seed) {
        const TracedNodes nodes = nodes_of(blur, seed);
        const KnotFit fit = fit_knots(nodes, epsilon);
        EXPECT_NEAR(fit.objective, true_objective(fit.table, nodes), 0.2 * fit.objective + 1e-9) << blur;
        EXPECT_LE(fit.objective, epsilon) << blur;
        EXPECT_EQ(fit.evaluations, 4 * fit.table.knots().size());
      }
    }
  }
}

TEST(FitKnots, HasTheMassOfItsTarget) {
  for (const float blur : {0.02f, 0.1f, 0.4f}) {
    const TracedNodes nodes = nodes_of(blur);
    EXPECT_FLOAT_EQ(fit_knots(nodes, 0.01).table.energy(), nodes.energy());
  }
  const TracedNodes none({}, 0.2f);
  EXPECT_EQ(fit_knots(none, 0.01).table.energy(), 0.0f);
  EXPECT_EQ(fit_knots(none, 0.01).objective, 0.0);
}

TEST(FitKnots, TakesAsManyKnotsAsTheRowNeeds) {
  EXPECT_EQ(fit_knots(nodes_of(0.4f), 0.01).table.knots().size(), 32u);
  EXPECT_EQ(fit_knots(nodes_of(0.12f), 0.001).table.knots().size(), 64u);
  EXPECT_EQ(fit_knots(nodes_of(0.07f), 0.001).table.knots().size(), 128u);
  // One degree of blur: 128 knots are three blurs apart, and say that they do not hold it.
  const KnotFit narrow = fit_knots(nodes_of(0.0175f), 0.001);
  EXPECT_EQ(narrow.table.knots().size(), 128u);
  EXPECT_GT(narrow.objective, 0.001);
}

// The projection is the best there is: at the knots themselves g errs by five times as much (h^4 g''^2/120 against
// /720), and no other line is nearer.
TEST(FitKnots, ErrsASixthOfWhatTheValuesAtItsKnotsWould) {
  const TracedNodes nodes = nodes_of(0.3f);
  const KnotDensity table = fit_knots(nodes, 0.01).table;
  std::vector<Knot> at_knots(table.knots().size());
  for (std::size_t k = 0; k < at_knots.size(); ++k) {
    at_knots[k].density =
        nodes.density(static_cast<float>(-pi + 2 * pi * static_cast<double>(k) / static_cast<double>(at_knots.size())));
  }
  const double ratio = true_objective(KnotDensity(at_knots), nodes) / true_objective(table, nodes);
  EXPECT_GT(ratio, 4);
  EXPECT_LT(ratio, 6.5);
  for (std::size_t k = 0; k < at_knots.size(); k += 5) {
    for (const float factor : {0.99f, 1.01f}) {
      std::vector<Knot> moved(table.knots().begin(), table.knots().end());
      if (moved[k].density < 0.01f) continue;
      moved[k].density *= factor;
      EXPECT_GE(true_objective(KnotDensity(moved), nodes), true_objective(table, nodes)) << k;
    }
  }
}

TEST(FitKnots, NeverGoesBelowZero) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const TracedNodes nodes = nodes_of(0.03f, seed);
    const KnotFit fit = fit_knots(nodes, 1);
    for (const Knot& knot : fit.table.knots()) EXPECT_GE(knot.density, 0.0f);
    EXPECT_FLOAT_EQ(fit.table.energy(), nodes.energy());
  }
}

double gamma_share(double sigma_a, double mean, double variance) {
  if (variance < 1e-9 * mean * mean) return std::exp(-sigma_a * mean);
  return std::pow(1 + sigma_a * variance / mean, -mean * mean / variance);
}

// Light under absorption: each hat with the gamma law of its moments, against every ray with its own path. The law has
// two moments right and misses sigma_a^3/6 of a third cumulant: at most 0.1 d^3 where the blur brings rays of two paths
// d <= 2 apart to one knot, 0.13 sigma_a^3 in all; and few knots are such.
TEST(FitKnots, PathMomentsGiveTheLightOfAColor) {
  for (const float blur : {0.08f, 0.2f, 0.4f}) {
    const TracedNodes nodes = nodes_of(blur);
    const KnotDensity table = with_attributes(fit_knots(nodes, 0.001).table, nodes);
    const double h = 2 * pi / static_cast<double>(table.knots().size());
    for (const double sigma_a : {0.05, 0.4, 1.0, 3.0}) {
      double reported = 0, actual = 0, clear = 0, first = 0, first_actual = 0;
      for (const Knot& knot : table.knots()) {
        reported += h * knot.density * gamma_share(sigma_a, knot.attribute_mean, knot.attribute_variance);
        first += h * knot.density * static_cast<double>(knot.attribute_mean);
      }
      for (std::size_t j = 0; j < nodes.size(); ++j) {
        actual += nodes.weight()[j] * std::exp(-sigma_a * nodes.attribute()[j]);
        clear += nodes.weight()[j];
        first_actual += static_cast<double>(nodes.weight()[j]) * nodes.attribute()[j];
      }
      EXPECT_NEAR(reported / actual, 1, 1e-5 + 0.004 * sigma_a * sigma_a * sigma_a)
          << "blur " << blur << ", sigma_a " << sigma_a;
      EXPECT_NEAR(first / first_actual, 1, 1e-3);
      EXPECT_GT(clear, actual);
    }
  }
}

TEST(FitKnots, RaysOfOnePathHaveNoVariance) {
  std::vector<TracedRay> rays;
  for (int i = 0; i < 64; ++i) rays.push_back({0.05f * static_cast<float>(i), 0.01f, 2.5f});
  const TracedNodes nodes(rays, 0.2f);
  const KnotDensity table = with_attributes(fit_knots(nodes, 0.01).table, nodes);
  for (const Knot& knot : table.knots()) {
    EXPECT_NEAR(knot.attribute_mean, 2.5f, 1e-5f);
    EXPECT_NEAR(knot.attribute_variance, 0, 1e-5f);
  }
}

// Half way between two of the 512 points of the largest table, a spike of a sixteenth of their distance: at every point
// g is 0, and what was fitted there was called exact.
TEST(FitKnots, WhatItsPointsCannotSeeIsNotTakenForFitted) {
  const auto between = static_cast<float>(pi / 512);
  const KnotFit fit = fit_knots(TracedNodes(std::vector<TracedRay>{{between, 1.0f, 1.0f}}, between / 8), 0.01);
  EXPECT_EQ(fit.objective, 1);
  EXPECT_EQ(fit.evaluations, 0u);
  EXPECT_FLOAT_EQ(fit.table.energy(), 1);
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
