// The learner on targets made here: blurred rays with folds (caustics), and on junk.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

#include "fit/fit_mixture.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr double pi = std::numbers::pi;

// Rays whose azimuth folds back twice in h, as TRT's does: two caustics, blurred.
TracedNodes folded_target(std::uint64_t seed, float sigma) {
  RandomStream random(seed);
  const float centre = 6 * random.next() - 3, slope = 2 * random.next() - 1, bend = 2 * random.next();
  std::vector<TracedRay> rays;
  for (int i = 0; i < 512; ++i) {
    const float h = -1 + (2 * static_cast<float>(i) + 1) / 512;
    rays.push_back({centre + slope * h - bend * h * h * h, (1 - 0.6f * h * h) / 512, 1 + h});
  }
  return {rays, sigma};
}

double relative_l2(const Mixture& fit, const TracedNodes& nodes) {
  constexpr int points = 4096;  // midpoints: the largest slope of a fit leaves under 1e-5
  double sum = 0;
  for (int i = 0; i < points; ++i) {
    const auto x = static_cast<float>(-pi + 2 * pi * (i + 0.5) / points);
    const double r = fit.density(x) - nodes.density(x);
    sum += r * r;
  }
  return sum * 2 * pi / points / nodes.variation();
}

void expect_constraints(const Mixture& fit) {
  EXPECT_LE(fit.component_count, 8u);
  EXPECT_GE(fit.uniform_weight, 0.0f);
  EXPECT_TRUE(std::isfinite(fit.energy()));
  for (const Component& part : fit.parts()) {
    EXPECT_GE(part.weight, 0.0f);
    EXPECT_GE(part.shape.s_left, 0.004f);
    EXPECT_LE(part.shape.s_left, 0.5f);
    EXPECT_GE(part.shape.s_right, 0.004f);
    EXPECT_LE(part.shape.s_right, 0.5f);
    EXPECT_GE(part.shape.mu, -std::numbers::pi_v<float>);
    EXPECT_LT(part.shape.mu, std::numbers::pi_v<float>);
  }
}

void cover(Sketch& sketch, const TracedNodes& nodes) {
  for (const float x : gap_fill_azimuths(sketch.pairs(), nodes.blur_rad())) sketch.offer(x, nodes.density(x));
}

// Coverage, fit, 16 own draws, until the true error is below epsilon: the evaluations that it took, 0 if over 10
// rounds.
int evaluations_to(double epsilon, const TracedNodes& nodes, RandomStream random) {
  Sketch sketch(Sketch::bin_count(nodes.blur_rad()));
  Fit fit;
  for (int round = 0; round < 10; ++round) {
    cover(sketch, nodes);
    fit = fit_mixture(sketch.pairs(), nodes.energy(), nodes.variation(), round > 0 ? &fit.mixture : nullptr,
                      {epsilon, 8});
    expect_constraints(fit.mixture);
    if (relative_l2(fit.mixture, nodes) < epsilon) return static_cast<int>(sketch.occupied());
    for (int i = 0; i < 16; ++i) {
      const float x = fit.mixture.sample(random.next(), 0.05f);
      sketch.offer(x, nodes.density(x));
    }
  }
  return 0;
}

void expect_learned(double epsilon) {
  std::vector<int> counts;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const float sigma = seed % 3 == 0 ? 0.0873f : seed % 3 == 1 ? 0.175f : 0.349f;
    const int count = evaluations_to(epsilon, folded_target(seed, sigma), RandomStream(1, seed));
    EXPECT_GT(count, 0) << "seed " << seed;
    counts.push_back(count);
  }
  std::sort(counts.begin(), counts.end());
  std::printf("epsilon %g: g evaluations kept, median %d, largest %d\n", epsilon, counts[30], counts.back());
}

TEST(Learner, ReachesOnePerCentOnFoldedTargets) { expect_learned(0.01); }
TEST(Learner, ReachesOnePerMilleOnFoldedTargets) { expect_learned(0.001); }

TEST(Learner, KeepsTheKnownEnergy) {
  const TracedNodes nodes = folded_target(4, 0.175f);
  Sketch sketch(216);
  cover(sketch, nodes);
  const Fit fit = fit_mixture(sketch.pairs(), nodes.energy(), nodes.variation(), nullptr, {});
  EXPECT_NEAR(fit.mixture.energy(), nodes.energy(), 1e-6);
}

TEST(Learner, AFlatTargetNeedsNoComponent) {
  std::vector<ObservedPair> pairs;
  for (int i = 0; i < 40; ++i) pairs.push_back({-3.1f + 0.155f * static_cast<float>(i), 0.1f});
  const Fit fit = fit_mixture(pairs, 0.2 * pi, 0, nullptr, {});
  EXPECT_EQ(fit.mixture.component_count, 0u);
  EXPECT_NEAR(fit.mixture.uniform_weight, 0.2 * pi, 1e-6);
}

// Either start is good enough (R below epsilon/4) or the warm one is no worse than the cold one.
TEST(Learner, WarmStartIsNoWorseThanCold) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const TracedNodes nodes = folded_target(seed, 0.1f);
    const Mixture wrong = fit_mixture({}, 0.5, 1, nullptr, {}).mixture;
    Mixture off = wrong;
    off.component_count = 1;
    off.components[0] = {{2.0f, 0.01f, 0.5f}, 0.4f};
    Sketch sketch(Sketch::bin_count(0.1f));
    for (int i = 0; i < 60; ++i) {
      const float x = -3.14f + 0.1046f * static_cast<float>(i);
      sketch.offer(x, nodes.density(x));
    }
    const FitSettings settings{0.001, 8};
    const Fit cold = fit_mixture(sketch.pairs(), nodes.energy(), nodes.variation(), nullptr, settings);
    const Fit warm = fit_mixture(sketch.pairs(), nodes.energy(), nodes.variation(), &off, settings);
    EXPECT_LE(warm.objective, std::max(settings.epsilon / 4, cold.objective) * 1.05) << seed;  // rescaling to E
  }
}

TEST(Learner, JunkStillGivesALegalMixture) {
  RandomStream random(77);
  for (int round = 0; round < 300; ++round) {
    std::vector<ObservedPair> pairs;
    const int count = static_cast<int>(random.next() * 60);
    const float top = std::pow(10.0f, 60 * random.next() - 30);
    for (int i = 0; i < count; ++i) {
      const float x = random.next() < 0.2f ? 1.0f : 6.28f * random.next() - 3.14f;
      pairs.push_back({x, round % 5 == 0 ? 0.0f : top * random.next()});
    }
    Mixture warm;
    warm.component_count = 2;
    warm.components[0] = {{1.0f, 0.004f, 0.5f}, 0.0f};
    warm.components[1] = {{-3.0f, 0.2f, 0.1f}, top};
    const double energy = round % 7 == 0 ? 0 : random.next();
    const Fit fit = fit_mixture(pairs, energy, random.next(), round % 2 == 0 ? &warm : nullptr, {0.001, 8});
    expect_constraints(fit.mixture);
    EXPECT_FALSE(std::isnan(fit.objective));
    EXPECT_NEAR(fit.mixture.energy(), energy, 1e-5);
  }
  const float huge = std::numeric_limits<float>::max();
  expect_constraints(fit_mixture(std::vector<ObservedPair>(30, {0.5f, huge}), 1, 1, nullptr, {}).mixture);
  expect_constraints(fit_mixture(std::vector<ObservedPair>{{0.5f, 1.0f}}, NAN, NAN, nullptr, {}).mixture);
}

TEST(Attributes, FollowTheRaysOfEachComponent) {
  std::vector<TracedRay> rays;
  for (int i = 0; i < 200; ++i) {
    rays.push_back({-1.5f, 0.002f, i % 2 == 0 ? 1.0f : 3.0f});
    rays.push_back({1.5f, 0.002f, 7.0f});
  }
  Mixture mixture;
  mixture.component_count = 2;
  mixture.components[0] = {{-1.5f, 0.06f, 0.06f}, 0.4f};
  mixture.components[1] = {{1.5f, 0.06f, 0.06f}, 0.4f};
  assign_attributes(mixture, TracedNodes(rays, 0.1f));
  // The components overlap by exp(-3/0.06): far below the tolerance.
  EXPECT_NEAR(mixture.components[0].attribute_mean, 2, 1e-4);
  EXPECT_NEAR(mixture.components[0].attribute_variance, 1, 1e-3);
  EXPECT_NEAR(mixture.components[1].attribute_mean, 7, 1e-4);
  EXPECT_NEAR(mixture.components[1].attribute_variance, 0, 1e-3);
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
