// The error of a fit by a bound: held against integrals, for targets and fits of all kinds.
#include "fit/known_error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include "fit/fit_mixture.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr double pi = std::numbers::pi;

struct Case {
  TracedNodes nodes;
  Mixture fit;
};

/// Blurs of 0.6 to 30 degrees, 1 to 12 directions of very different mass, half of them on a flat ground; fits of any
/// scales anywhere, or fitted to 40 pairs.
Case random_case(std::uint64_t seed) {
  RandomStream random(61, seed);
  const float blur = 0.0105f * std::pow(50.0f, random.next());
  std::vector<TracedRay> rays;
  const int directions = 1 + static_cast<int>(12 * random.next());
  for (int i = 0; i < directions; ++i) {
    rays.push_back({6.28f * random.next(), std::pow(10.0f, -3 * random.next()), 1.0f});
  }
  if (seed % 2 == 0) {
    const auto many = static_cast<int>(12 / blur);
    for (int i = 0; i < many; ++i) rays.push_back({6.2831853f * float(i) / float(many), 3.0f / float(many), 1.0f});
  }
  Case made{TracedNodes(rays, blur), {}};
  if (seed % 3 == 0) {
    std::vector<ObservedPair> pairs;
    for (int i = 0; i < 40; ++i) {
      const float x = wrap_angle(rays[0].azimuth + blur * 6 * (random.next() - 0.5f) * (i % 2 == 0 ? 1.0f : 20.0f));
      pairs.push_back({x, made.nodes.density(x)});
    }
    std::ranges::sort(pairs, {}, &ObservedPair::azimuth);
    made.fit = fit_mixture(pairs, made.nodes.energy(), made.nodes.variation(), nullptr, {0.001, 8}).mixture;
    return made;
  }
  const auto parts = static_cast<std::uint32_t>(9 * random.next());
  float left = made.nodes.energy();
  for (std::uint32_t i = 0; i < parts; ++i) {
    Component& part = made.fit.components[made.fit.component_count++];
    const auto scale = [&] { return 0.004f * std::pow(125.0f, random.next()); };
    part.weight = left * random.next();
    left -= part.weight;
    part.shape = {wrap_angle(6.28f * random.next()), scale(), scale()};
  }
  made.fit.uniform_weight = left;
  return made;
}

/// Norm of g - f, relative, 1/32 of the narrowest scale and of the blur apart.
double norm(const Case& one) {
  double narrowest = one.nodes.blur_rad();
  for (const Component& part : one.fit.parts()) {
    narrowest = std::min<double>(narrowest, std::min(part.shape.s_left, part.shape.s_right));
  }
  const auto points = static_cast<int>(64 * pi / narrowest);
  double sum = 0;
  for (int i = 0; i < points; ++i) {
    const auto x = static_cast<float>(2 * pi * i / points - pi);
    const double off = static_cast<double>(one.nodes.density(x)) - static_cast<double>(one.fit.density(x));
    sum += off * off;
  }
  return std::sqrt(sum * 2 * pi / points / static_cast<double>(one.nodes.variation()));
}

// Sums at half of the narrowest scale differ from the integral where a side of a component meets the other: by 1e-3 of
// the norm of the error at most in these cases. Densities are floats, to 1e-5 of the norm of g.
TEST(KnownError, BoundsTheErrorOfAnyFitOfAnyTarget) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const Case one = random_case(seed);
    const KnownError error = known_error(one.fit, one.nodes, one.nodes.grid());
    const double truth = norm(one);
    const double mean = one.nodes.energy() / (2 * pi);
    const double scale = std::sqrt((one.nodes.variation() + 2 * pi * mean * mean) / one.nodes.variation());
    const double tolerance = 1e-3 * truth + 1e-5 * scale;
    EXPECT_LE(truth, std::sqrt(error.most) + tolerance) << seed;
    EXPECT_LE(std::abs(truth - std::sqrt(error.seen)), std::sqrt(error.most) - std::sqrt(error.seen) + tolerance)
        << seed;
    EXPECT_TRUE(std::isfinite(error.most) && error.seen >= 0 && error.most >= error.seen) << seed;
  }
}

// With twice the steps next to nothing is hidden, and both numbers are the error.
TEST(KnownError, IsTheErrorOnTwiceTheSteps) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const Case one = random_case(seed);
    std::vector<float> grid(2 * one.nodes.grid().size());
    for (std::size_t i = 0; i < grid.size(); ++i) {
      grid[i] = one.nodes.density(
          static_cast<float>(2 * pi * static_cast<double>(i) / static_cast<double>(grid.size()) - pi));
    }
    const KnownError error = known_error(one.fit, one.nodes, grid);
    const double mean = one.nodes.energy() / (2 * pi);
    const double scale = std::sqrt((one.nodes.variation() + 2 * pi * mean * mean) / one.nodes.variation());
    EXPECT_NEAR(std::sqrt(error.most), std::sqrt(error.seen), 1e-6 * scale) << seed;
    EXPECT_NEAR(std::sqrt(error.seen), norm(one), 1e-3 * norm(one) + 1e-5 * scale) << seed;
  }
}

TEST(KnownError, OfARowWithoutLightIsNone) {
  const TracedNodes nodes({}, 0.1f);
  const KnownError error = known_error(Mixture{}, nodes, nodes.grid());
  EXPECT_EQ(error.seen, 0);
  EXPECT_EQ(error.most, 0);
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
