// The color that was asked for is the color that a lock shows.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "references/lock_ways.h"
#include "support/seed.h"
#include "tress/base/random.h"
#include "tress/fiber/lock_color.h"

namespace {

using namespace tress;

/// Seeds 41 and 42. Tolerance: what the fit may be off by (0.02) and five standard errors of the mean over the paths;
/// 18 colors: a false alarm in 100,000 runs.
TEST(LockColor, IsTheOneThatWasAsked) {
  RandomStream random(test::seed(41));
  for (int i = 0; i < 6; ++i) {
    fiber::FiberParameters fiber;
    fiber.eta = 1.35f + 0.45f * random.next();
    fiber.eccentricity = 0.5f + 0.5f * random.next();
    fiber.roughness = std::pow(0.02f, random.next());
    fiber.tilt = 8 * random.next() * std::numbers::pi_v<float> / 180;
    const std::vector<float> ways =
        references::lock_ways(fiber, references::seen_as_color(fiber, {.paths = 12'000, .seed = test::seed(42)}));
    for (const float color : {0.1f, 0.5f, 0.95f}) {
      if (color < references::lock_radiance(ways, 1e3) + 0.02) continue;  // its surface alone is nearly as light
      const double sigma_a = fiber::sigma_a_of_lock(glm::vec3(color), fiber).g;
      const double shown = references::lock_radiance(ways, sigma_a);
      const double square = references::lock_radiance(ways, 2 * sigma_a);
      const double error = std::sqrt((square - shown * shown) / static_cast<double>(ways.size()));
      EXPECT_NEAR(shown, static_cast<double>(color), 0.02 + 5 * error)
          << "eta " << fiber.eta << " e " << fiber.eccentricity << " alpha " << fiber.roughness << " tilt "
          << fiber.tilt;
    }
  }
}

/// As the middle of a round lock is seen, some 20 degrees from its normal: there dark fibers without tilt show more of
/// their surfaces than straight on. Seed 43; tolerance: what the fit is off by at its nodes (0.005) and five standard
/// errors of the mean over the paths; 10 colors: a false alarm in 100,000 runs.
TEST(LockColor, OfFibersWithoutTiltIsThatOfTheMiddleOfARoundLock) {
  for (const float alpha : {0.1f, 0.2f}) {
    fiber::FiberParameters fiber;
    fiber.eccentricity = 0.5f;
    fiber.roughness = alpha;
    fiber.tilt = 0;
    const std::vector<float> ways =
        references::lock_ways(fiber, references::seen_as_color(fiber, {.paths = 40'000, .seed = test::seed(43)}));
    for (const float color : {0.05f, 0.15f, 0.3f, 0.5f, 0.8f}) {
      const auto sigma_a = static_cast<double>(fiber::sigma_a_of_lock(glm::vec3(color), fiber).g);
      const double shown = references::lock_radiance(ways, sigma_a);
      const double square = references::lock_radiance(ways, 2 * sigma_a);
      const double error = std::sqrt((square - shown * shown) / static_cast<double>(ways.size()));
      EXPECT_NEAR(shown, static_cast<double>(color), 0.005 + 5 * error) << "alpha " << alpha;
    }
  }
}

}  // namespace
