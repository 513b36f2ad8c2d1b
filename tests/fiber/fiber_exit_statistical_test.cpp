// Where a traced path leaves a rough fiber, and the ways of tracing that leave its mean as it is.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "fiber/rough_fiber.h"
#include "support/seed.h"
#include "tress/base/random.h"

namespace tress::test {
namespace {

using fiber::FiberDirection;
using fiber::FiberExit;
using fiber::FiberParameters;
using fiber::RoughExit;
using fiber::RoughFiber;

constexpr FiberDirection wr{0.5f, 0.7f};

FiberParameters parameters(float eccentricity, float roughness) {
  FiberParameters fiber;
  fiber.eccentricity = eccentricity;
  fiber.roughness = roughness;
  fiber.tilt = 0;
  fiber.sigma_a = glm::vec3(0.0f);
  return fiber;
}

RoughExit path(const RoughFiber& rough, float h, RandomStream& random, float kept_inside = 1) {
  std::array<float, 4> u;
  for (float& number : u) number = random.next();
  return rough.trace(rough.entry(wr, h), u, random, kept_inside);
}

// A smooth circle keeps the offset from the axis (angular momentum): light that was refracted twice passes it on the
// other side of its way, and the first reflection leaves beside the middle of its arrival. alpha 0.002 bends by some
// 0.01.
TEST(fiber_exit, a_smooth_circle_keeps_the_offset) {
  const RoughFiber rough(parameters(1, 0.002f));
  RandomStream random(seed(71));
  for (int i = 0; i < 2000; ++i) {
    const float h = 1.6f * random.next() - 0.8f;
    const RoughExit exit = path(rough, h, random);
    ASSERT_TRUE(exit.place.is_known);
    EXPECT_NEAR(std::abs(exit.place.across), std::abs(h), 0.03f) << exit.order;
    if (exit.order == 0) {  // the same place of the surface, and the same way to the axis, mirrored
      const float to_axis = std::sqrt(1 - h * h) * std::tan(wr.theta);
      EXPECT_NEAR(exit.place.along, 2 * to_axis, 0.06f);
    }
  }
}

// What hardly bends goes straight on: it passes the axis where the ray that came would have.
TEST(fiber_exit, light_that_does_not_bend_stays_on_its_line) {
  FiberParameters fiber = parameters(0.6f, 0.002f);
  fiber.eta = 1.05f;
  const RoughFiber rough(fiber);
  RandomStream random(seed(72));
  for (int i = 0; i < 500; ++i) {
    const RoughExit exit = path(rough, 0.3f, random);
    if (exit.order != 1) continue;
    const float half_width = std::hypot(0.6f * std::cos(wr.phi), std::sin(wr.phi));
    EXPECT_NEAR(exit.place.across, 0.3f * half_width, 0.05f);
    EXPECT_NEAR(exit.place.along, 0, 0.1f);
  }
}

struct Sums {
  double light = 0, light2 = 0, across = 0, across2 = 0;
  int count = 0;
  void add(double weight, const FiberExit& place) {
    ++count;
    light += weight;
    light2 += weight * weight;
    across += weight * static_cast<double>(place.across);
    across2 += weight * weight * static_cast<double>(place.across * place.across);
  }
};

void expect_equal(double sum_a, double squares_a, int count_a, double sum_b, double squares_b, int count_b) {
  const double a = sum_a / count_a, b = sum_b / count_b;
  const double variance = (squares_a / count_a - a * a) / count_a + (squares_b / count_b - b * b) / count_b;
  EXPECT_NEAR(a, b, 5 * std::sqrt(variance));
}

// Reflecting more often at the first facet changes no mean: of the light that a dark tilted fiber returns, and of where
// it leaves. 5 standard errors, twice.
TEST(fiber_exit, favored_reflection_has_the_same_mean) {
  FiberParameters fiber = parameters(0.7f, 0.3f);
  fiber.tilt = 0.05f;
  fiber.sigma_a = glm::vec3(2.0f);
  const RoughFiber rough(fiber);
  RandomStream random(seed(73));
  std::array<Sums, 2> sums;
  for (int i = 0; i < 400000; ++i) {
    Sums& one = sums[static_cast<std::size_t>(i % 2)];
    const RoughExit exit = path(rough, 2 * random.next() - 1, random, i % 2 == 0 ? 1 : 0.05f);
    one.add(static_cast<double>(exit.throughput.x), exit.place);
  }
  expect_equal(sums[0].light, sums[0].light2, sums[0].count, sums[1].light, sums[1].light2, sums[1].count);
  expect_equal(sums[0].across, sums[0].across2, sums[0].count, sums[1].across, sums[1].across2, sums[1].count);
}

// Estimates over all directions have the light of traced paths, and leave from the same places. 5 standard errors,
// three times.
TEST(fiber_exit, estimates_leave_where_paths_do) {
  const RoughFiber rough(parameters(0.7f, 0.3f));
  RandomStream random(seed(74));
  Sums one, all, traced;
  const float pi = std::numbers::pi_v<float>;
  for (int i = 0; i < 600000; ++i) {
    const float h = 2 * random.next() - 1;
    if (i % 3 == 0) {
      const RoughExit exit = path(rough, h, random);
      traced.add(static_cast<double>(exit.throughput.x), exit.place);
      continue;
    }
    RoughFiber::FacetNumbers u;
    for (auto& pair : u) pair = {random.next(), random.next()};
    const FiberDirection wi{pi * (random.next() - 0.5f), pi * (2 * random.next() - 1)};
    const fiber::RoughEntry entry = rough.entry(wr, h);
    FiberExit place;
    const fiber::LobeColors s =
        i % 3 == 1 ? rough.estimate(entry, wi, u, random, place) : rough.estimate(entry, wi, u, random);
    double total = 0;
    for (const glm::vec3& lobe : s) total += static_cast<double>(2 * pi * pi * lobe.y);
    (i % 3 == 1 ? one : all).add(total, place);
  }
  expect_equal(one.light, one.light2, one.count, all.light, all.light2, all.count);
  expect_equal(one.light, one.light2, one.count, traced.light, traced.light2, traced.count);
  expect_equal(one.across, one.across2, one.count, traced.across, traced.across2, traced.count);
}

}  // namespace
}  // namespace tress::test
