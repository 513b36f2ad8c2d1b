// The paper's adaptive importance sampling on targets made here, and on junk.
#include "references/learners/ais.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <limits>
#include <numbers>
#include <vector>

#include "references/ais_targets.h"

namespace tress::inline v0_2::adaptive {
namespace {

using tress::testing::relative_l2;
using tress::testing::target_of;
using tress::testing::two_lobes;

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

// A single component is in the family: L2 goes to the threshold, and the parameters with it. About the optimum
// O = delta^T H delta: a relative L2 of 1e-6 leaves mu within 0.002 of a scale or two, and scales within 1 %.
TEST(Ais, RecoversASingleComponent) {
  const SkewLogistic truth{0.8f, 0.1f, 0.25f};
  const AisTarget target = target_of([&](float x) { return 0.7 * static_cast<double>(truth.density(x)); });
  for (const AisDistance distance : {AisDistance::l2, AisDistance::relative_entropy}) {
    AisSettings settings;
    settings.components = 1;
    settings.threshold = 1e-6;
    settings.distance = distance;
    const AisFit fit = fit_ais(target, RandomStream(1), settings);
    EXPECT_EQ(fit.end, AisEnd::reached);
    ASSERT_EQ(fit.mixture.component_count, 1u);
    const Component& part = fit.mixture.components[0];
    EXPECT_NEAR(part.shape.mu, truth.mu, 0.002);
    EXPECT_NEAR(part.shape.s_left, truth.s_left, 0.01 * truth.s_left);
    EXPECT_NEAR(part.shape.s_right, truth.s_right, 0.01 * truth.s_right);
    EXPECT_NEAR(part.weight, 0.7, 0.007);
    EXPECT_NEAR(fit.mixture.energy(), 0.7, 1e-5);
  }
}

// Every combination of section 5's choices. Gaussian lobes: one skew logistic a lobe leaves 0.0042 in the median (D =
// 1), so that three may leave 0.01 at most.
TEST(Ais, FitsTwoLobesByEveryChoice) {
  for (const float turn : {0.0f, 1.0f}) {
    const AisTarget target = two_lobes(turn);
    for (const auto distance : {AisDistance::l2, AisDistance::relative_entropy}) {
      for (const auto weighting : {AisWeighting::target, AisWeighting::alternate, AisWeighting::uniform}) {
        for (const auto sweep : {AisSweep::complete, AisSweep::sequential, AisSweep::alternate}) {
          for (const auto step : {AisStep::newton, AisStep::gradient}) {
            AisSettings settings;
            settings.components = 3;
            settings.samples = 128;
            settings.distance = distance;
            settings.weighting = weighting;
            settings.sweep = sweep;
            settings.step = step;
            const AisFit fit = fit_ais(target, RandomStream(3), settings);
            expect_constraints(fit.mixture);
            EXPECT_LT(relative_l2(target, fit.mixture), 0.01)
                << "h " << int(distance) << " weighting " << int(weighting) << " sweep " << int(sweep) << " step "
                << int(step) << " turn " << turn;
          }
        }
      }
    }
  }
}

TEST(Ais, MoreComponentsFitBetter) {
  const AisTarget target = two_lobes();
  double before = 1;
  for (const int d : {1, 2, 3, 5, 8}) {
    AisSettings settings;
    settings.components = d;
    const double error = relative_l2(target, fit_ais(target, RandomStream(5), settings).mixture);
    std::printf("D = %d: %.2g\n", d, error);
    // From 3 on it ends by the threshold of 1e-4 or by the noise of the samples, near which order is chance.
    EXPECT_LT(error, std::max(before, 5e-4)) << "D " << d;
    before = error;
  }
}

TEST(Ais, IsAPureFunction) {
  const AisTarget target = two_lobes();
  const AisFit a = fit_ais(target, RandomStream(7)), b = fit_ais(target, RandomStream(7));
  const AisFit other = fit_ais(target, RandomStream(8));
  EXPECT_EQ(a.history, b.history);
  EXPECT_EQ(a.objective, b.objective);
  EXPECT_EQ(a.g_evaluations, b.g_evaluations);
  for (std::size_t d = 0; d < Mixture::max_components; ++d) {
    EXPECT_EQ(a.mixture.components[d].shape.mu, b.mixture.components[d].shape.mu);
    EXPECT_EQ(a.mixture.components[d].weight, b.mixture.components[d].weight);
  }
  EXPECT_NE(a.history, other.history);
}

TEST(Ais, CountsEveryEvaluation) {
  std::uint64_t asked = 0;
  AisTarget target = two_lobes();
  const auto g = target.density;
  target.density = [&](float x) {
    ++asked;
    EXPECT_GE(x, -std::numbers::pi_v<float>);
    EXPECT_LT(x, std::numbers::pi_v<float>);
    return g(x);
  };
  for (const AisBasis basis : {AisBasis::circular, AisBasis::line}) {
    asked = 0;
    AisSettings settings;
    settings.basis = basis;
    EXPECT_EQ(fit_ais(target, RandomStream(2), settings).g_evaluations, asked);
  }
}

// Constraints hold, and what can be fitted is, whatever g is.
TEST(Ais, AdversarialTargets) {
  const auto spike = [](double width) {
    return target_of([width](float x) { return std::abs(static_cast<double>(x) - 1) < width / 2 ? 1 / width : 0.0; });
  };
  const auto flat = target_of([](float) { return 0.1; });
  const auto dust = target_of([](float x) { return 1e-9 * static_cast<double>(wrapped_gaussian(x, 0.2f)); });
  const auto steps = target_of([](float x) { return x > 0 ? 1.0 : 0.0; });
  const std::vector<AisTarget> targets{flat, dust, steps, spike(0.3), spike(0.02), spike(1e-3)};
  for (const auto distance : {AisDistance::l2, AisDistance::relative_entropy}) {
    for (const auto basis : {AisBasis::circular, AisBasis::line}) {
      for (const auto start : {AisStart::spread, AisStart::sample}) {
        AisSettings settings;
        settings.distance = distance;
        settings.basis = basis;
        settings.start = start;
        settings.components = 8;
        settings.iterations = 20;
        settings.samples = 64;
        for (const AisTarget& target : targets) {
          const AisFit fit = fit_ais(target, RandomStream(9), settings);
          expect_constraints(fit.mixture);
          EXPECT_TRUE(std::isfinite(fit.objective));
          EXPECT_NE(fit.end, AisEnd::refused);
          EXPECT_NEAR(fit.mixture.energy(), target.energy, 1e-4 * target.energy);
        }
        EXPECT_LT(relative_l2(flat, fit_ais(flat, RandomStream(9), settings).mixture), 1e-3);
      }
    }
  }
}

TEST(Ais, RefusesWhatIsNoDensity) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();
  const auto one = [](float) { return 1.0; };
  const std::vector<AisTarget> targets{{one, 0, 1},
                                       {one, nan, 1},
                                       {one, -1, 1},
                                       {one, infinite, 1},
                                       {one, 1, nan},
                                       {{}, 1, 1},
                                       {[](float x) { return x > 1 ? std::nan("") : 1.0; }, 1, 1},
                                       {[=](float x) { return x > 1 ? infinite : 1.0; }, 1, 1},
                                       {[](float x) { return x > 1 ? -0.1 : 1.0; }, 1, 1}};
  for (const AisTarget& target : targets) {
    const AisFit fit = fit_ais(target, RandomStream(1));
    EXPECT_EQ(fit.end, AisEnd::refused);
    EXPECT_EQ(fit.mixture.component_count, 0u);
    EXPECT_TRUE(std::isfinite(fit.mixture.uniform_weight));
    EXPECT_GE(fit.mixture.uniform_weight, 0.0f);
  }
}

// Out of range settings are brought into it, never a crash.
TEST(Ais, SettingsOutOfRange) {
  AisSettings settings;
  settings.components = 100;
  settings.samples = -3;
  settings.iterations = 0;
  settings.steps = 0;
  settings.uniform_share = 7;
  settings.stop_window = 0;
  expect_constraints(fit_ais(two_lobes(), RandomStream(1), settings).mixture);
  settings.components = -1;
  settings.uniform_share = -1;
  settings.iterations = 5;
  settings.uniform_part = false;
  expect_constraints(fit_ais(two_lobes(), RandomStream(1), settings).mixture);
}

TEST(Ais, StopsEarlyWhereNothingIsWon) {
  const AisTarget target = two_lobes();
  AisSettings settings;
  settings.components = 1;  // cannot fit
  settings.iterations = 80;
  EXPECT_EQ(fit_ais(target, RandomStream(4), settings).end, AisEnd::stopped);
  for (const AisStop never : {AisStop::none, AisStop::printed}) {
    settings.stop = never;
    const AisFit fit = fit_ais(target, RandomStream(4), settings);
    EXPECT_EQ(fit.end, AisEnd::exhausted);
    EXPECT_EQ(fit.iterations, 80);
    EXPECT_EQ(fit.history.size(), 79u);
  }
  settings.stop = AisStop::mended;
  settings.threshold = 0;
  settings.components = 3;
  settings.weighting = AisWeighting::target;  // one objective, not two by turns
  settings.samples = 4096;                    // with less noise than eps
  const AisFit fit = fit_ais(target, RandomStream(4), settings);
  EXPECT_EQ(fit.end, AisEnd::stopped);
  EXPECT_EQ((fit.history.size() - 1) % 15, 0u);
}

// On the line a lobe at +-pi is two halves, which the periodicity term makes meet; on the circle it has nothing to do.
TEST(Ais, PeriodicityTermClosesTheLine) {
  const AisTarget target = two_lobes();
  const auto gap = [&](double tau) {
    AisSettings settings;
    settings.basis = AisBasis::line;
    settings.periodicity = tau;
    settings.components = 3;
    const Mixture fit = fit_ais(target, RandomStream(6), settings).mixture;
    return relative_l2(target, fit);
  };
  EXPECT_LT(gap(10), 0.2);
  AisSettings settings;
  const AisFit with = fit_ais(target, RandomStream(6), settings);
  settings.periodicity = 0;
  EXPECT_EQ(with.history, fit_ais(target, RandomStream(6), settings).history);
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
