#include "tress/fiber/rounded_shape.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "base/pi.h"
#include "tress/fiber/parameter_ranges.h"

namespace tress::fiber {
namespace {

constexpr auto degree_f = static_cast<float>(degree);

TEST(RoundedShape, KeepsTheMeanOfWhatItRounds) {
  FiberParameters fiber;
  fiber.eccentricity = 0.853f;
  fiber.roughness = 10.3f * degree_f;
  fiber.tilt = 2.6f * degree_f;
  fiber.medulla_radius = 0.42f;
  double e = 0, alpha = 0, tilt = 0, radius = 0;
  constexpr int draws = 1000;
  for (int i = 0; i < draws; ++i) {
    const float u = (static_cast<float>(i) + 0.5f) / draws;
    const FiberParameters rounded = rounded_shape(fiber, {u, u, u});
    e += static_cast<double>(rounded.eccentricity) / draws;
    alpha += static_cast<double>(rounded.roughness) / degree / draws;
    tilt += static_cast<double>(rounded.tilt) / degree / draws;
    radius += static_cast<double>(rounded.medulla_radius) / draws;
    EXPECT_EQ(rounded.sigma_a, fiber.sigma_a);
  }
  // A mean of 1,000 even draws is right within a step over 1,000.
  EXPECT_NEAR(e, 0.853, 2e-5);
  EXPECT_NEAR(alpha, 10.3, 2e-3);
  EXPECT_NEAR(tilt, 2.6, 1e-3);
  EXPECT_NEAR(radius, 0.42, 1e-4);
}

TEST(RoundedShape, LeavesWhatIsOnAStepAndStaysInRange) {
  FiberParameters fiber;
  fiber.eccentricity = 1;
  fiber.roughness = 12 * degree_f;
  fiber.tilt = 3 * degree_f;
  for (const float u : {0.0f, 0.5f, 0x1.fffffep-1f}) {
    const FiberParameters rounded = rounded_shape(fiber, {u, u, u});
    EXPECT_EQ(rounded.eccentricity, 1);
    EXPECT_FLOAT_EQ(rounded.roughness, fiber.roughness);
    EXPECT_FLOAT_EQ(rounded.tilt, fiber.tilt);
    fiber.roughness = 0.012f;
    EXPECT_EQ(out_of_range(rounded_shape(fiber, {u, u, u})), nullptr);
    fiber.roughness = 12 * degree_f;
  }
}

TEST(RoundedShape, AllShapesOfARangeAreWhatRoundingReturns) {
  FiberParameters least, most;
  least.eccentricity = 0.845f, most.eccentricity = 0.86f;
  least.roughness = most.roughness = 10.5f * degree_f;
  least.tilt = 2 * degree_f, most.tilt = 3 * degree_f;
  const std::vector<FiberParameters> all = rounded_shapes(least, most);
  EXPECT_EQ(all.size(), 3u * 2u * 3u);  // 0.84 to 0.86; 10 and 11 degrees; 2, 2.5, 3 degrees
  for (int i = 0; i <= 20; ++i) {
    const float s = static_cast<float>(i) / 20;
    FiberParameters between = least;
    between.eccentricity += s * (most.eccentricity - least.eccentricity);
    between.tilt += s * (most.tilt - least.tilt);
    for (const float u : {0.0f, 0.4f, 0.9f}) {
      EXPECT_NE(std::ranges::find(all, rounded_shape(between, {u, 1 - u - 0.05f, u})), all.end()) << s << " " << u;
    }
  }
}

TEST(RoundedShape, ClampsWhatIsOutOfRange) {
  constexpr float infinity = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
  for (float FiberParameters::* member : {&FiberParameters::eccentricity, &FiberParameters::roughness,
                                          &FiberParameters::tilt, &FiberParameters::medulla_radius}) {
    FiberParameters low, high;
    low.*member = -1, high.*member = 4;
    const FiberParameters least = rounded_shape(low, {0, 0, 0}), most = rounded_shape(high, {0, 0, 0});
    for (const float x : {nan, infinity, -infinity, 3e38f, -3e38f}) {
      FiberParameters fiber;
      fiber.*member = x;
      EXPECT_EQ(rounded_shape(fiber, {0, 0, 0}), x > 0 ? most : least) << x;
      const std::size_t all = rounded_shapes(fiber, high).size();
      EXPECT_TRUE(all > 0 && all < 1000) << all;
    }
  }
  for (const float u : {nan, infinity, -infinity, 3e38f})
    EXPECT_EQ(rounded_shape({}, {u, u, u}),
              rounded_shape({}, u > 0 ? std::array{1.0f, 1.0f, 1.0f} : std::array<float, 3>{}));
}

}  // namespace
}  // namespace tress::fiber
