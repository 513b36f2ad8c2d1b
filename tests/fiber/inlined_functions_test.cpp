// The logarithm and the angle that hot paths have inlined, against libm in double precision.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "base/arctangent.h"
#include "base/logarithm.h"
#include "tress/base/random.h"

namespace {

using tress::angle_of;
using tress::natural_log;
using tress::RandomStream;

// The documented bounds: 2e-7 of the logarithm, 3e-7 of a radian.
void expect_log(float x) {
  const double truth = std::log(static_cast<double>(x));
  EXPECT_NEAR(natural_log(x), truth, 2e-7 * std::abs(truth)) << x;
}

TEST(InlinedFunctions, NaturalLogKeepsItsBound) {
  RandomStream random(1);
  for (int i = 0; i < 100000; ++i) {
    expect_log(std::exp2(252 * random.next() - 126));
    expect_log(0.5f + random.next());
    expect_log(1 + (random.next() - 0.5f) * 1e-3f);
  }
  for (const float x : {std::numeric_limits<float>::min(), 0.70710677f, 0.70710683f, 1.0f, 1.4142135f, 1.4142137f,
                        std::numeric_limits<float>::max()}) {
    expect_log(x);
  }
  EXPECT_EQ(natural_log(1), 0);
}

void expect_angle(float y, float x) {
  EXPECT_NEAR(angle_of(y, x), std::atan2(static_cast<double>(y), static_cast<double>(x)), 3e-7) << y << ' ' << x;
}

TEST(InlinedFunctions, AngleOfKeepsItsBoundInEveryQuadrantAndOnTheAxes) {
  RandomStream random(2);
  for (int i = 0; i < 100000; ++i) {
    const float turn = 2 * std::numbers::pi_v<float> * random.next(), length = std::exp2(40 * random.next() - 20);
    expect_angle(length * std::sin(turn), length * std::cos(turn));
  }
  for (const float y : {-1.0f, 0.0f, 0.41421356f, 1.0f}) {
    for (const float x : {-1.0f, 0.41421356f, 1.0f}) expect_angle(y, x);
  }
  expect_angle(1, 0);
  expect_angle(-1, 0);
  EXPECT_EQ(angle_of(0.0f, 0.0f), 0);
}

}  // namespace
