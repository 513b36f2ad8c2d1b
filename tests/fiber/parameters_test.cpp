#include "tress/fiber/parameters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fiber/lobe_widths.h"
#include "fiber/reference_data.h"
#include "support/quadrature.h"

namespace {

using namespace tress;
using test::degree;

TEST(Curl, AgreesWithReference) {
  const auto rows = test::reference_rows("curl.csv");
  ASSERT_FALSE(rows.empty());
  for (const auto& row : rows) {  // the table's tolerance: relative 1e-6
    const double e = std::stod(row[0]), diameter = fiber::curl_diameter_cm(e);
    EXPECT_NEAR(fiber::curl_type(e), std::min(std::stod(row[2]), 8.0), 1e-6 * 8) << e;
    EXPECT_NEAR(diameter, std::stod(row[3]), 1e-6 * diameter) << e;
    const double d =
        std::remainder(fiber::major_axis_rotation(7.3, diameter) - std::stod(row[7]), 2 * std::numbers::pi);
    EXPECT_NEAR(d, 0, 1e-6 * 2 * 7.3 / diameter) << e;
  }
}

TEST(Curl, ClampsFlatFibers) {
  EXPECT_EQ(fiber::curl_type(0.5), 8);
  EXPECT_DOUBLE_EQ(fiber::curl_diameter_cm(0.5), 0.2);
}

TEST(Ellipse, MeanProjectedWidthIsThatOfTheCircle) {
  for (float e : {0.5f, 0.7f, 0.85f, 1.0f}) {
    const double mean = test::integrate([&](double phi) { return fiber::projected_half_width(float(phi), e); }, 0,
                                        2 * std::numbers::pi) /
                        (2 * std::numbers::pi);
    EXPECT_NEAR(fiber::major_semi_axis(3.0, e) * mean, 3.0, 3e-6) << e;  // single precision widths
  }
}

TEST(Widths, FollowRoughnessUnlessGiven) {
  fiber::FiberParameters fiber;
  fiber.roughness = 0.2f;
  EXPECT_FLOAT_EQ(fiber::azimuthal_sigmas(fiber)[0], 0.1f);
  EXPECT_FLOAT_EQ(fiber::azimuthal_sigmas(fiber)[1], 0.36f);
  EXPECT_FLOAT_EQ(fiber::longitudinal_lambda(fiber, 0, 0.3f), 0.078f);
  EXPECT_FLOAT_EQ(fiber::longitudinal_lambda(fiber, 1, 1.0f), 0.0392f / std::cos(1.0f));
  fiber.roughness = 1;
  EXPECT_FLOAT_EQ(fiber::azimuthal_sigmas(fiber)[2], float(45 * degree));
  EXPECT_FLOAT_EQ(fiber::longitudinal_lambda(fiber, 3, 0), float(45 * degree));
  EXPECT_FLOAT_EQ(fiber::longitudinal_lambda(fiber, 1, 1.5707964f), float(45 * degree));
  fiber.roughness = 0.01f;
  EXPECT_FLOAT_EQ(fiber::longitudinal_lambda(fiber, 0, 0), float(0.25 * degree));
  fiber.azimuthal_sigma[1] = 0.2f;
  fiber.longitudinal_lambda[2] = 0.3f;
  EXPECT_EQ(fiber::azimuthal_sigmas(fiber)[1], 0.2f);
  EXPECT_EQ(fiber::longitudinal_lambda(fiber, 2, 0), 0.3f);
}

TEST(Widths, TiltsAreTowardsTheRootForReflection) {
  fiber::FiberParameters fiber;
  fiber.tilt = 0.1f;
  EXPECT_FLOAT_EQ(fiber::lobe_tilt(fiber, 0), -0.1f);
  EXPECT_FLOAT_EQ(fiber::lobe_tilt(fiber, 1), 0.05f);
  EXPECT_FLOAT_EQ(fiber::lobe_tilt(fiber, 2), 0.15f);
  EXPECT_FLOAT_EQ(fiber::lobe_tilt(fiber, 3), 0.25f);
}

// TRRT and the residual of `elliptical`: 0.9 alpha for one bounce and the scales' tilt for those that follow, to
// float's precision; everything else is as published.
TEST(Widths, ScalesSpreadWhatEllipticalReturnsAfterTrtAndDoNotTurnIt) {
  const int later = fiber::LobeWidths::lane_of(3);
  fiber::FiberParameters fiber;
  fiber.roughness = 0.1f;
  for (const float tilt : {0.0f, 0.05f, 0.14f}) {
    fiber.tilt = tilt;
    const auto published = fiber::LobeWidths(fiber).at(0.6f), traced = fiber::LobeWidths::as_traced(fiber).at(0.6f);
    EXPECT_EQ(traced.tilt[later], 0);
    EXPECT_FLOAT_EQ(traced.lambda[later], 0.09f + tilt);
    for (int lane = 0; lane < 4; ++lane) {
      EXPECT_EQ(traced.shift[lane], published.shift[lane]);
      if (lane == later && tilt > 0) continue;
      EXPECT_EQ(traced.tilt[lane], published.tilt[lane]) << lane;
      EXPECT_EQ(traced.lambda[lane], published.lambda[lane]) << lane;
    }
  }
  fiber.roughness = 1;
  EXPECT_FLOAT_EQ(fiber::LobeWidths::as_traced(fiber).at(0).lambda[later], float(45 * degree));
  fiber.longitudinal_lambda[3] = 0.2f;
  const auto given = fiber::LobeWidths::as_traced(fiber).at(0);
  EXPECT_EQ(given.lambda[later], 0.2f);
  EXPECT_FLOAT_EQ(given.tilt[later], 2.5f * fiber.tilt);
}

TEST(Widths, RoughnessBringsTransmittedLobesNearerToTheNormalPlane) {
  fiber::FiberParameters fiber;
  fiber.roughness = 0.1f;
  EXPECT_EQ(fiber::roughness_shift(fiber, 0, 1.0f), 0.0f);
  for (const int p : {1, 2, 3}) {
    EXPECT_EQ(fiber::roughness_shift(fiber, p, 0.0f), 0.0f);
    float last = 0;
    for (int i = 1; i <= 90; ++i) {
      const float theta = std::min(static_cast<float>(i * degree), 1.5707963f);
      const float shift = fiber::roughness_shift(fiber, p, theta);
      EXPECT_GT(shift, last) << p << ' ' << i;
      EXPECT_LE(shift, theta / (p == 1 ? 10.0f : 4.0f)) << p << ' ' << i;
      EXPECT_EQ(fiber::roughness_shift(fiber, p, -theta), -shift);
      last = shift;
    }
  }
  fiber.longitudinal_lambda[1] = 0.1f;
  EXPECT_EQ(fiber::roughness_shift(fiber, 1, 1.0f), 0.0f);
  EXPECT_GT(fiber::roughness_shift(fiber, 2, 1.0f), 0.0f);
}

TEST(Absorption, FromColorAndMelanin) {
  const glm::vec3 absorbed = fiber::sigma_a_from_color(glm::vec3(0.2f, 0.5f, 0.9f));
  // Chiang et al. 2016, eq. 9 with beta_N = 0.3: the denominator is 5.969 - 0.0645 + 0.22788 - 0.28971 + 0.04515 +
  // 0.0006.
  for (int c = 0; c < 3; ++c) {
    const double color[3] = {0.2, 0.5, 0.9};
    EXPECT_NEAR(absorbed[c], std::pow(std::log(color[c]) / 5.8884149, 2), 1e-6);
  }
  const glm::vec3 melanin = fiber::sigma_a_from_melanin(2, 1);
  EXPECT_NEAR(melanin.g, 2 * 0.697 + 0.4, 1e-6);
  const glm::vec3 black = fiber::sigma_a_from_color(glm::vec3(0, 1, 0.5f));
  EXPECT_TRUE(std::isfinite(black.r));
  EXPECT_EQ(black.g, 0);
}

}  // namespace
