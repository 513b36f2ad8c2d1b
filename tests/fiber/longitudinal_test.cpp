#include "fiber/longitudinal.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/quadrature.h"

namespace {

using namespace tress;
using fiber::half_pi;
using fiber::LongitudinalLobe;

constexpr float inclinations[] = {-half_pi, -1.5f, -0.7f, 0.0f, 0.3f, 1.2f, 1.56f, half_pi};
constexpr float tilts[] = {-0.5f, -0.0524f, 0.0f, 0.0262f, 0.131f, 1.0f};
constexpr float scales[] = {fiber::smallest_lambda, 0.02f, 0.1f, 0.3f, 0.7854f};

TEST(Longitudinal, IntegratesToOne) {
  // 4096 panels are 11 to a scale at the smallest lambda (theta_i moves by 2 lambda); single precision densities are
  // good to a few 1e-6 in x = 200, times the slope of the exponent.
  for (float theta_r : inclinations) {
    for (float tilt : tilts) {
      for (float lambda : scales) {
        const LongitudinalLobe lobe(theta_r, tilt, lambda);
        EXPECT_NEAR(test::integrate([&](double t) { return lobe.density(float(t)); }, -half_pi, half_pi, 4096), 1, 5e-5)
            << theta_r << ' ' << tilt << ' ' << lambda;
      }
    }
  }
}

TEST(Longitudinal, SampleInvertsTheDistribution) {
  for (float theta_r : inclinations) {
    for (float tilt : tilts) {
      for (float lambda : scales) {
        const LongitudinalLobe lobe(theta_r, tilt, lambda);
        for (float u : {0.01f, 0.3f, 0.5f, 0.9f}) {
          const float theta = lobe.sample(u);
          ASSERT_LE(std::abs(theta), half_pi);
          const double below = test::integrate([&](double t) { return lobe.density(float(t)); }, -half_pi, theta, 2048);
          EXPECT_NEAR(below, u, 2e-4) << theta_r << ' ' << tilt << ' ' << lambda;
        }
      }
    }
  }
}

TEST(Longitudinal, PeaksAtTheSpecularConeMovedByTwiceTheTilt) {
  const LongitudinalLobe lobe(0.4f, 0.05f, 0.02f);
  EXPECT_GT(lobe.density(-0.3f), lobe.density(-0.31f));
  EXPECT_GT(lobe.density(-0.3f), lobe.density(-0.29f));
  EXPECT_NEAR(lobe.sample(0.5f), -0.3f, 1e-5);
  // A logistic peaks at 1/(4 lambda) in theta_h, half of that in theta_i.
  EXPECT_NEAR(lobe.density(-0.3f), 1 / (8 * 0.02), 1e-4);
}

TEST(Longitudinal, EndsOfTheUnitIntervalStayInRange) {
  for (float theta_r : inclinations) {
    for (float tilt : {-1.5f, 0.0f, 1.5f}) {
      for (float lambda : {0.0f, 0.01f, 0.7854f}) {
        const LongitudinalLobe lobe(theta_r, tilt, lambda);
        for (float u : {0.0f, 1e-30f, 0.99999994f, 1.0f}) {
          const float theta = lobe.sample(u);
          ASSERT_TRUE(std::abs(theta) <= half_pi);
          ASSERT_TRUE(std::isfinite(lobe.density(theta)));
        }
      }
    }
  }
}

}  // namespace
