#include "scene/generate/generated_environments.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "scene/model/light.h"
#include "scene/read/scene_file.h"

namespace tress::scene {
namespace {

const GradientSky sky{{1, 2, 4}, {3, 3, 3}, {0.5f, 0.25f, 0}};

/// Mean over the sphere: half of it ground, half horizon/3 + 2 zenith/3.
TEST(SkyEnvironment, HasItsAnalyticMean) {
  const auto environment = gradient_environment(sky, 2);
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(environment.mean()[c], sky.ground[c] + sky.horizon[c] / 3 + 2 * sky.zenith[c] / 3, 1e-6);
}

/// Linear in the root of the sine in 1024 steps.
TEST(SkyEnvironment, RunsFromHorizonToZenithAboveTheGround) {
  const auto environment = gradient_environment(sky, 1);
  const auto at = [&](double elevation, double azimuth) {
    return environment.radiance(direction_towards(azimuth, elevation));
  };
  for (const double azimuth : {0.0, 1.0, 3.0, -2.0}) {
    EXPECT_NEAR(at(std::numbers::pi / 2 - 1e-4, azimuth).b, 4, 1e-4);
    EXPECT_NEAR(at(std::numbers::pi / 6, azimuth).b, 3 + std::sqrt(0.5), 1e-5);
    EXPECT_NEAR(at(1e-4, azimuth).b, 3, 0.05);
    EXPECT_EQ(at(-1e-4, azimuth).b, 0);
    EXPECT_EQ(at(-1.5, azimuth), sky.ground);
  }
}

TEST(SkyEnvironment, TurnsAndScalesItsSun) {
  EnvironmentDescription description;
  description.kind = EnvironmentDescription::Kind::sky;
  EXPECT_FALSE(sun_of(description, description.rotate_deg));
  description.sun = Light{};
  description.sun->direction = direction_towards(0, 0.5);
  description.sun->radiance = {10, 9, 8};
  description.rotate_deg = 90;
  description.scale = 3;
  const auto sun = sun_of(description, description.rotate_deg);
  ASSERT_TRUE(sun);
  EXPECT_EQ(sun->radiance, glm::vec3(30, 27, 24));
  const auto expected = direction_towards(std::numbers::pi / 2, 0.5);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(sun->direction[c], expected[c], 1e-6);
  // A map's pixel at that place turns the same way.
  std::vector<glm::vec3> pixels(64 * 32, glm::vec3(0.0f));
  for (const std::size_t row : {10, 11}) pixels[row * 64 + 31] = pixels[row * 64 + 32] = glm::vec3(1.0f);
  const Environment map(64, 32, pixels, std::numbers::pi / 2, 1);
  EXPECT_NEAR(map.radiance(sun->direction).r, 1, 1e-6);
  description.kind = EnvironmentDescription::Kind::studio;
  EXPECT_FALSE(sun_of(description, description.rotate_deg));
}

}  // namespace
}  // namespace tress::scene
