#include "tress/fiber/principled_hair.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "fiber/reference_data.h"
#include "tress/fiber/lock_color.h"
#include "tress/fiber/parameter_ranges.h"

namespace {

using namespace tress;
using fiber::PrincipledHair;
using test::degree;

TEST(PrincipledHair, AnySettingIsAFiberThatEveryModelTakes) {
  for (const float roughness : {0.0f, 0.3f, 1.0f})
    for (const float radial : {0.0f, 0.3f, 1.0f})
      for (const float coat : {0.0f, 1.0f})
        for (const float offset_deg : {-90.0f, 2.0f, 90.0f}) {
          PrincipledHair hair;
          hair.roughness = roughness;
          hair.radial_roughness = radial;
          hair.coat = coat;
          hair.offset = static_cast<float>(offset_deg * degree);
          EXPECT_EQ(fiber::out_of_range(fiber::fiber_of(hair)), nullptr) << roughness << " " << radial << " " << coat;
          hair.aspect_ratio = 0.1f;
          EXPECT_EQ(fiber::out_of_range(fiber::fiber_of(hair)), nullptr) << roughness;
        }
}

TEST(PrincipledHair, WidthsRiseWithTheirRoughnessAndACoatNarrowsTheFirstReflectionAlone) {
  PrincipledHair hair, rougher, coated;
  rougher.roughness = 0.4f;
  coated.coat = 0.5f;
  const auto usual = fiber::fiber_of(hair), rough = fiber::fiber_of(rougher), coat = fiber::fiber_of(coated);
  for (std::size_t p = 0; p < 4; ++p) EXPECT_GT(*rough.longitudinal_lambda[p], *usual.longitudinal_lambda[p]);
  EXPECT_EQ(rough.azimuthal_sigma, usual.azimuthal_sigma);
  EXPECT_LT(*coat.longitudinal_lambda[0], *usual.longitudinal_lambda[0]);
  for (std::size_t p = 1; p < 4; ++p) EXPECT_EQ(coat.longitudinal_lambda[p], usual.longitudinal_lambda[p]);
  EXPECT_EQ(usual.eccentricity, 1.0f);
}

/// v_R = (0.726 b + 0.812 b^2)^2, v_TT = v_R/4, v_TRT = 4 v_R; s = sqrt(pi/8) (0.265 b + 1.194 b^2), whose deviation is
/// pi/sqrt 3 s, at b = 0.3, where the last terms of the publication (3.7 b^20, 5.372 b^22) are nothing. To the rounding
/// of floats.
TEST(PrincipledHair, PublishedWidthsAreThoseOfThePublication) {
  PrincipledHair hair;
  hair.widths = fiber::PrincipledWidths::published;
  const auto made = fiber::fiber_of(hair);
  const double of_r = 0.726 * 0.3 + 0.812 * 0.09, to_deviation = 2 * std::numbers::pi / std::numbers::sqrt3;
  const double sigma =
      std::sqrt(std::numbers::pi / 8) * (0.265 * 0.3 + 1.194 * 0.09) * std::numbers::pi / std::numbers::sqrt3;
  for (const auto& [p, times] : {std::pair{0, 1.0}, {1, 0.5}, {2, 2.0}, {3, 2.0}})
    EXPECT_NEAR(to_deviation * double{*made.longitudinal_lambda[static_cast<std::size_t>(p)]}, times * of_r, 1e-6) << p;
  for (const auto& width : made.azimuthal_sigma) EXPECT_NEAR(double{*width}, sigma, 1e-6);
}

/// What `chiang2016` draws, and what every other model does.
TEST(PrincipledHair, LeftOpenTheWidthsAreTheFittedOnesWithThePublishedBeside) {
  PrincipledHair open, fitted, published;
  fitted.widths = fiber::PrincipledWidths::fitted;
  published.widths = fiber::PrincipledWidths::published;
  fiber::FiberParameters made = fiber::fiber_of(open);
  const fiber::FiberParameters theirs = fiber::fiber_of(published);
  ASSERT_TRUE(made.published_widths);
  EXPECT_EQ(made.published_widths, theirs.published_widths);
  for (std::size_t p = 0; p < 4; ++p)
    EXPECT_EQ(made.published_widths->longitudinal_lambda[p], *theirs.longitudinal_lambda[p]) << p;
  for (std::size_t p = 0; p < 3; ++p)
    EXPECT_EQ(made.published_widths->azimuthal_sigma[p], *theirs.azimuthal_sigma[p]) << p;
  made.published_widths.reset();
  EXPECT_EQ(made, fiber::fiber_of(fitted));
}

/// MaterialX's roughness node and Principled Hair make the same variances and scales of one roughness.
TEST(PrincipledHair, MaterialXsNodeIsTheSameFiber) {
  PrincipledHair hair;
  hair.offset = 0.05f;
  hair.sigma_a = {0.1f, 0.2f, 0.4f};
  fiber::ChiangHair node;
  const float l = 0.726f * 0.3f + 0.812f * 0.09f, s = 0.265f * 0.3f + 1.194f * 0.09f;
  node.longitudinal_variance = {l * l, 0.25f * l * l, 4 * l * l};
  node.azimuthal_scale = {s, s, s};
  node.cuticle_angle = static_cast<float>(0.5 + 0.05 / std::numbers::pi);
  node.sigma_a = hair.sigma_a;
  const auto a = fiber::fiber_of(hair), b = fiber::fiber_of(node);
  for (std::size_t p = 0; p < 4; ++p) EXPECT_NEAR(*a.longitudinal_lambda[p], *b.longitudinal_lambda[p], 1e-5) << p;
  for (std::size_t p = 0; p < 3; ++p) EXPECT_NEAR(*a.azimuthal_sigma[p], *b.azimuthal_sigma[p], 1e-5) << p;
  EXPECT_NEAR(a.tilt, b.tilt, 1e-6);
  EXPECT_EQ(a.eta, b.eta);
  EXPECT_EQ(a.sigma_a, b.sigma_a);
  EXPECT_EQ(a.gain, b.gain);
}

TEST(PrincipledHair, MaterialXsTintsAreOfTheirLobesAndAnySettingIsAFiber) {
  fiber::ChiangHair node;
  node.tint = {glm::vec3(0.25f), glm::vec3(0.5f), glm::vec3(0.75f)};
  const auto made = fiber::fiber_of(node);
  const std::array<float, fiber::lobe_count> expected{0.25f, 0.5f, 0.75f, 0.75f, 0.75f, 0.75f};
  for (std::size_t p = 0; p < expected.size(); ++p) EXPECT_EQ(made.gain[p], glm::vec3(expected[p])) << p;
  EXPECT_EQ(made.tilt, 0.0f);
  for (const float variance : {1e-6f, 10.0f})
    for (const float cuticle : {0.0f, 1.0f}) {
      node.longitudinal_variance.fill(variance);
      node.azimuthal_scale.fill(variance);
      node.cuticle_angle = cuticle;
      EXPECT_EQ(fiber::out_of_range(fiber::fiber_of(node)), nullptr) << variance << " " << cuticle;
    }
}

/// By hand: melanin 0.5, half of it red, is ln 2 of each half; white has no absorption.
TEST(PrincipledHair, MelaninAndColorsAreTheNodes) {
  const glm::vec3 half = fiber::sigma_a_of_principled_melanin(0.5f, 0.5f);
  EXPECT_NEAR(half.x, std::log(2.0) * 0.5 * (0.506 + 0.343), 1e-6);
  EXPECT_NEAR(half.z, std::log(2.0) * 0.5 * (1.653 + 1.924), 1e-6);
  EXPECT_EQ(fiber::sigma_a_of_principled_melanin(0, 0.3f), glm::vec3(0.0f));
  EXPECT_EQ(fiber::sigma_a_of_principled_color({1, 1, 1}, 0.3f), glm::vec3(0.0f));
  // beta_N = 0.3: 5.969 - 0.0645 + 0.22788 - 0.28971 + 0.0451494 + 0.00059535.
  const double root = std::log(0.2) / 5.88841475;
  EXPECT_NEAR(fiber::sigma_a_of_principled_color({0.2f, 0.5f, 0.5f}, 0.3f).x, root * root, 1e-6);
}

TEST(PrincipledHair, ColorsThatAreNoneAreClamped) {
  constexpr float infinity = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
  const fiber::FiberParameters fiber;
  for (const float x : {nan, infinity, -infinity, 3e38f, -3e38f, 2.0f, -1.0f}) {
    const float end = x > 0 ? 1.0f : 0.0f;
    EXPECT_EQ(fiber::sigma_a_of_principled_color(glm::vec3(x), 0.3f),
              fiber::sigma_a_of_principled_color(glm::vec3(end), 0.3f));
    EXPECT_EQ(fiber::sigma_a_of_principled_color(glm::vec3(0.2f), x),
              fiber::sigma_a_of_principled_color(glm::vec3(0.2f), end));
    EXPECT_EQ(fiber::sigma_a_of_principled_melanin(x, 0.3f), fiber::sigma_a_of_principled_melanin(end, 0.3f));
    EXPECT_EQ(fiber::sigma_a_of_principled_melanin(0.3f, x), fiber::sigma_a_of_principled_melanin(0.3f, end));
    EXPECT_EQ(fiber::sigma_a_of_lock(glm::vec3(x), fiber), fiber::sigma_a_of_lock(glm::vec3(end), fiber));
    for (float fiber::FiberParameters::* member : {&fiber::FiberParameters::eta, &fiber::FiberParameters::eccentricity,
                                                   &fiber::FiberParameters::roughness, &fiber::FiberParameters::tilt}) {
      fiber::FiberParameters of = fiber, clamped = fiber;
      of.*member = x;
      clamped.*member = x > 0 ? 1e6f : 0.0f;
      EXPECT_EQ(fiber::sigma_a_of_lock(glm::vec3(0.5f), of), fiber::sigma_a_of_lock(glm::vec3(0.5f), clamped)) << x;
    }
  }
}

}  // namespace
