#include "image/view_transform.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace tress::image {
namespace {

constexpr View views[] = {View::standard, View::neutral, View::agx};

float srgb(float x) { return x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1 / 2.4f) - 0.055f; }

TEST(ViewTransform, NamesAreThoseOfTheViews) {
  for (const View view : views) EXPECT_EQ(view_of(view_names()[static_cast<std::size_t>(view)]), view);
  EXPECT_FALSE(view_of("filmic"));
}

TEST(ViewTransform, StandardIsSrgbCutOffAtOne) {
  for (const float x : {0.0f, 0.001f, 0.18f, 0.5f, 1.0f})
    EXPECT_NEAR(displayed(View::standard, glm::vec3(x)).y, srgb(x), 1e-6f);
  const glm::vec3 cut = displayed(View::standard, {4, 0.5f, -1});
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(cut[c], glm::vec3(1, srgb(0.5f), 0)[c], 1e-6f);
}

/// What the specification of Khronos promises: 1:1 below 0.8 but for the light that a dielectric reflects, F90 = 0.04.
TEST(ViewTransform, NeutralKeepsColorsBelowTheKnee) {
  const glm::vec3 color(0.6f, 0.3f, 0.1f), shown = displayed(View::neutral, color);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(shown[c], srgb(color[c] - 0.04f), 1e-5f);
  // The knee is smooth: value and slope of both sides agree.
  const auto at = [](float x) { return displayed(View::neutral, glm::vec3(x)).x; };
  EXPECT_NEAR(at(0.801f) - at(0.8f), at(0.8f) - at(0.799f), 2e-5f);
}

/// The sigmoid of AgX has its pivot at middle grey, which a display with a power of 2.4 shows as middle grey; the
/// polynomial is 0.007 off there.
TEST(ViewTransform, AgxShowsMiddleGreyAsMiddleGrey) {
  EXPECT_NEAR(std::pow(displayed(View::agx, glm::vec3(0.18f)).x, 2.4f), 0.18f, 0.01f);
  EXPECT_NEAR(displayed(View::agx, glm::vec3(0.18f * std::exp2(6.5f))).x, 1, 0.005f);
  EXPECT_NEAR(displayed(View::agx, glm::vec3(0.18f * std::exp2(-10.0f))).x, 0, 0.005f);
}

/// A saturated highlight goes to white, as no display can show it brighter in its own color; cut off it stays orange.
TEST(ViewTransform, BrightColorsGoToWhite) {
  const glm::vec3 orange(1, 0.3f, 0.02f);
  const auto saturation = [&](View view, float scale) {
    const glm::vec3 shown = displayed(view, scale * orange);
    return 1 - shown.z / shown.x;
  };
  EXPECT_NEAR(saturation(View::standard, 4), 1 - srgb(0.08f), 1e-5f);
  for (const View view : {View::neutral, View::agx}) {
    EXPECT_LT(saturation(view, 16), saturation(view, 4));
    EXPECT_LT(saturation(view, 64), 0.2f);
  }
}

TEST(ViewTransform, GreysStayGreyRiseAndEveryInputIsShown) {
  for (const View view : views) {
    float before = -1;
    for (float x = 0; x < 30; x = 1.05f * x + 0.001f) {
      const glm::vec3 shown = displayed(view, glm::vec3(x));
      EXPECT_NEAR(shown.x, shown.y, 2e-3f) << x;
      EXPECT_NEAR(shown.x, shown.z, 2e-3f) << x;
      EXPECT_GE(shown.x, before - 1e-6f) << x;
      before = shown.x;
    }
    constexpr float infinite = std::numeric_limits<float>::infinity(),
                    no_number = std::numeric_limits<float>::quiet_NaN();
    for (const float x : {no_number, infinite, -infinite, 3e38f, -3e38f, 1e-40f})
      for (const glm::vec3& color : {glm::vec3(x), glm::vec3(x, 0, 1), glm::vec3(0, -x, x)}) {
        const glm::vec3 shown = displayed(view, color);
        for (int c = 0; c < 3; ++c) EXPECT_TRUE(shown[c] >= 0 && shown[c] <= 1) << x;
      }
  }
}

}  // namespace
}  // namespace tress::image
