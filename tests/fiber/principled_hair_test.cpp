#include "tress/fiber/principled_hair.h"

#include <gtest/gtest.h>

#include <cmath>

#include "fiber/reference_data.h"
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

}  // namespace
