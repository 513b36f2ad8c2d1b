#include "base/quarter_sine.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace {

using namespace tress;

TEST(QuarterSine, AgreesWithTheLibrary) {
  // The bounds that the header states.
  constexpr int steps = 20000;
  constexpr float end = 0x1.921fb6p+0f;  // pi/2 rounded
  for (int k = -steps; k <= steps; ++k) {
    const float x = end * float(k) / steps;
    const double sine = std::sin(double(x)), cosine = std::max(std::cos(double(x)), 0.0);
    EXPECT_NEAR(quarter_sine(x), sine, 2e-7 * std::abs(sine)) << x;
    EXPECT_NEAR(quarter_cosine(x), cosine, 3e-7 * std::max(std::abs(cosine), 1e-6)) << x;
    EXPECT_GE(quarter_cosine(x), 0);
  }
}

}  // namespace
