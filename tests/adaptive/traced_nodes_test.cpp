// g from traced rays against the sum of wrapped Gaussians in double.
#include "tress/adaptive/traced_nodes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "support/quadrature.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr double pi = std::numbers::pi;

std::vector<TracedRay> random_rays(int count, std::uint64_t seed) {
  RandomStream random(seed);
  std::vector<TracedRay> rays;
  for (int i = 0; i < count; ++i) {
    const float turn = random.next();
    rays.push_back({20 * turn * turn * turn - 10, random.next() / static_cast<float>(count), random.next()});
  }
  return rays;
}

double reference(const std::vector<TracedRay>& rays, double x, double sigma) {
  double sum = 0;
  for (const TracedRay& ray : rays) {
    const double d = std::remainder(x - ray.azimuth, 2 * pi);
    for (int turn = -3; turn <= 3; ++turn) {
      const double y = (d + 2 * pi * turn) / sigma;
      sum += ray.weight * std::exp(-0.5 * y * y);
    }
  }
  return sum / (sigma * std::sqrt(2 * pi));
}

TEST(TracedNodes, DensityIsTheSumOfWrappedGaussians) {
  for (const double degrees : {0.5, 5.0, 20.0, 45.0, 90.0}) {
    const double sigma = degrees * pi / 180;
    const auto rays = random_rays(301, 3);
    const TracedNodes nodes(rays, static_cast<float>(sigma));
    for (double x = -7; x < 7; x += 0.173) {
      const double g = reference(rays, x, sigma);
      // Float azimuths: 5e-7 rad over sigma, at up to 6 sigma: 6 * 5e-7/sigma; what lies beyond 6 sigma is cut.
      EXPECT_NEAR(nodes.density(static_cast<float>(x)), g, g * (4e-6 + 6e-6 / sigma) + 3e-8 / sigma) << degrees;
    }
  }
}

TEST(TracedNodes, MassIsTheEnergyAndVariationIsTheIntegral) {
  for (const double degrees : {2.0, 10.0, 45.0}) {
    const auto rays = random_rays(200, 5);
    const TracedNodes nodes(rays, static_cast<float>(degrees * pi / 180));
    const auto g = [&](double x) { return nodes.density(static_cast<float>(x)); };
    EXPECT_NEAR(test::integrate(g, -pi, pi, 400), nodes.energy(), 1e-6);
    const double mean = nodes.energy() / (2 * pi);
    const double variation = test::integrate([&](double x) { return (g(x) - mean) * (g(x) - mean); }, -pi, pi, 400);
    EXPECT_NEAR(nodes.variation() / std::max(variation, 1e-3 / (2 * pi)), 1, 1e-4);
  }
}

TEST(TracedNodes, KeepsSortedRaysOfPositiveWeight) {
  const std::vector<TracedRay> rays{{4.0f, 0.2f, 1}, {0.5f, 0.0f, 2}, {-1.0f, 0.3f, 3}};
  const TracedNodes nodes(rays, 0.1f);
  ASSERT_EQ(nodes.size(), 2u);
  EXPECT_LT(nodes.azimuth()[0], nodes.azimuth()[1]);
  EXPECT_NEAR(nodes.azimuth()[0], 4 - 2 * pi, 1e-6);
  EXPECT_EQ(nodes.attribute()[0], 1);
  EXPECT_NEAR(nodes.energy(), 0.5, 1e-7);
}

TEST(TracedNodes, WithoutRaysIsZero) {
  const TracedNodes nodes({}, 0.1f);
  EXPECT_EQ(nodes.density(1.0f), 0.0f);
  EXPECT_EQ(nodes.energy(), 0.0f);
  EXPECT_FLOAT_EQ(nodes.variation(), static_cast<float>(1e-3 / (2 * pi)));
}

TEST(WrappedGaussian, HasMassOne) {
  for (const float sigma : {0.01f, 0.3f, 1.0f, 4.0f}) {
    EXPECT_NEAR(test::integrate([&](double x) { return wrapped_gaussian(static_cast<float>(x), sigma); }, -pi, pi, 600),
                1, 1e-6);
  }
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
