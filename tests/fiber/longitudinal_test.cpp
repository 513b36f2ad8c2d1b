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

constexpr fiber::LongitudinalShape shapes[] = {fiber::LongitudinalShape::logistic, fiber::LongitudinalShape::gaussian,
                                               fiber::LongitudinalShape::cauchy};

TEST(Longitudinal, IntegratesToOne) {
  // 4096 panels are 11 to a scale at the smallest lambda (theta_i moves by 2 lambda). Single precision places x, up to
  // 360, within 2e-5, and so is the density of a logistic tail, of slope 1. That of a Gaussian one has the slope x: cut
  // off so far out (a tilt of a radian, or none of the peak left at grazing), 360 times as much is possible.
  for (const auto shape : shapes) {
    for (float theta_r : inclinations) {
      for (float tilt : tilts) {
        for (float lambda : scales) {
          const LongitudinalLobe lobe(theta_r, tilt, lambda, shape);
          const double mass =
              test::integrate([&](double t) { return lobe.density(float(t)); }, -half_pi, half_pi, 4096);
          EXPECT_NEAR(mass, 1, shape == fiber::LongitudinalShape::gaussian ? 2e-3 : 5e-5)
              << int(shape) << ' ' << theta_r << ' ' << tilt << ' ' << lambda;
          if (std::abs(tilt) < 0.2f && std::abs(theta_r) < 1.57f) {
            EXPECT_NEAR(mass, 1, 5e-5) << int(shape) << ' ' << theta_r << ' ' << tilt << ' ' << lambda;
          }
        }
      }
    }
  }
}

TEST(Longitudinal, SampleInvertsTheDistribution) {
  for (const auto shape : shapes) {
    for (float theta_r : inclinations) {
      for (float tilt : {-0.0524f, 0.0f, 0.131f, 1.0f}) {
        for (float lambda : scales) {
          const LongitudinalLobe lobe(theta_r, tilt, lambda, shape);
          for (float u : {0.01f, 0.5f, 0.9f}) {
            const float theta = lobe.sample(u);
            ASSERT_LE(std::abs(theta), half_pi);
            const double below =
                test::integrate([&](double t) { return lobe.density(float(t)); }, -half_pi, theta, 2048);
            // Of the range that is left at grazing, a float of theta_i may hold some 1e-3.
            EXPECT_NEAR(below, u, shape == fiber::LongitudinalShape::gaussian ? 3e-3 : 2e-4)
                << int(shape) << ' ' << theta_r << ' ' << tilt << ' ' << lambda;
          }
        }
      }
    }
  }
}

TEST(Longitudinal, PeaksAtTheSpecularConeMovedByTwiceTheTilt) {
  // Peaks in theta_h where nothing is cut off: logistic 1/(4 lambda), Gaussian 1/(sqrt(2 pi) 1.4971 lambda), Cauchy
  // 1/(1.7627 pi lambda) (more by the 4 % of its tails that are cut off); half of that in theta_i.
  const float peaks[] = {0.25f, 0.26647f, 0.18058f};
  for (int k = 0; k < 3; ++k) {
    const LongitudinalLobe lobe(0.4f, 0.05f, 0.02f, shapes[k]);
    EXPECT_GT(lobe.density(-0.3f), lobe.density(-0.31f));
    EXPECT_GT(lobe.density(-0.3f), lobe.density(-0.29f));
    EXPECT_NEAR(lobe.density(-0.3f) * 2 * 0.02, peaks[k], k == 2 ? 0.01 : 1e-4);
    if (k < 2) {
      EXPECT_NEAR(lobe.sample(0.5f), -0.3f, 1e-5);
    }
  }
}

TEST(Longitudinal, ShapesHaveTheSameHalfWidth) {
  // Half of the peak at 2 acosh(sqrt 2) lambda in theta_h, twice that in theta_i.
  const float half_width = 2 * 2 * std::acosh(std::sqrt(2.0f)) * 0.03f;
  for (const auto shape : shapes) {
    const LongitudinalLobe lobe(0.2f, 0, 0.03f, shape);
    for (float side : {-1.0f, 1.0f}) {
      EXPECT_NEAR(lobe.density(-0.2f + side * half_width) / lobe.density(-0.2f), 0.5, 1e-5) << int(shape);
    }
  }
}

TEST(Longitudinal, EndsOfTheUnitIntervalStayInRange) {
  for (const auto shape : shapes) {
    for (float theta_r : inclinations) {
      for (float tilt : {-1.5f, 0.0f, 1.5f}) {
        for (float lambda : {0.0f, 0.01f, 0.7854f}) {
          const LongitudinalLobe lobe(theta_r, tilt, lambda, shape);
          for (float u : {0.0f, 1e-30f, 0.99999994f, 1.0f}) {
            const float theta = lobe.sample(u);
            ASSERT_TRUE(std::abs(theta) <= half_pi);
            ASSERT_TRUE(std::isfinite(lobe.density(theta))) << int(shape) << theta_r << tilt << lambda;
          }
        }
      }
    }
  }
}

}  // namespace
