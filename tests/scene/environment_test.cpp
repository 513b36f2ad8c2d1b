#include "scene/environment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scene/studio_environment.h"
#include "tress/adaptive/random.h"

namespace tress::scene {
namespace {

constexpr double pi = std::numbers::pi;

Environment uneven_map(double rotate_rad) {
  RandomStream random(7);
  std::vector<glm::vec3> pixels;
  for (int i = 0; i < 16 * 8; ++i)
    pixels.push_back(i % 5 == 0 ? glm::vec3(0.0f) : glm::vec3(random.next(), random.next(), 10 * random.next()));
  return Environment(16, 8, std::move(pixels), rotate_rad, 2.0f);
}

/// Midpoints in azimuth and the cosine; the map's edges fall on cells of this grid only in azimuth, so 1e-3.
TEST(Environment, DensityIntegratesToOneAndMeanIsTheMean) {
  for (const auto& environment : {uneven_map(0.0), studio_environment(0.3, 1.0f), Environment(glm::vec3(0.5f))}) {
    constexpr int rows = 2000, columns = 512;
    double density = 0, red = 0;
    for (int i = 0; i < rows; ++i)
      for (int j = 0; j < columns; ++j) {
        const double z = -1 + 2 * (i + 0.5) / rows, r = std::sqrt(1 - z * z), a = 2 * pi * (j + 0.5) / columns;
        const glm::vec3 d(r * std::cos(a), r * std::sin(a), z);
        density += environment.pdf_solid_angle(d) * 4 * pi / (rows * columns);
        red += environment.radiance(d).r / (1.0 * rows * columns);
      }
    EXPECT_NEAR(density, 1, 3e-3);
    EXPECT_NEAR(red / environment.mean().r, 1, 3e-3);
  }
}

/// Seed 11, 2e5 draws into 16 x 8 bins by direction, expectations from the density: 103 pixels are not black; the 1e-6
/// quantile of chi-square with about 100 degrees of freedom is below 100 + 6 sqrt(200).
TEST(Environment, SamplesFollowTheDensity) {
  const auto environment = uneven_map(0.0);
  constexpr int draws = 200000;
  std::vector<double> seen(128, 0), expected(128, 0);
  RandomStream random(11);
  for (int i = 0; i < draws; ++i) {
    const float u1 = random.next(), u2 = random.next();
    const auto s = environment.sample(u1, u2);
    ASSERT_GT(s.pdf_solid_angle, 0);
    const double down = std::acos(std::clamp(static_cast<double>(s.direction.z), -1.0, 1.0));
    double turns = std::atan2(-s.direction.x, -s.direction.y) / (2 * pi) + 0.5;
    turns -= std::floor(turns);
    seen[static_cast<std::size_t>(std::min(7, static_cast<int>(down / pi * 8))) * 16 +
         static_cast<std::size_t>(std::min(15, static_cast<int>(turns * 16)))] += 1;
  }
  double statistic = 0;
  int bins = 0;
  for (int row = 0; row < 8; ++row)
    for (int column = 0; column < 16; ++column) {
      const double down = pi * (row + 0.5) / 8, a = 2 * pi * ((column + 0.5) / 16 - 0.5);
      const glm::vec3 d(-std::sin(down) * std::sin(a), -std::sin(down) * std::cos(a), std::cos(down));
      const double solid = 2 * pi / 16 * (std::cos(pi * row / 8) - std::cos(pi * (row + 1) / 8));
      const double e = draws * environment.pdf_solid_angle(d) * solid;
      const auto k = static_cast<std::size_t>(row * 16 + column);
      if (e < 5) continue;
      statistic += (seen[k] - e) * (seen[k] - e) / e;
      ++bins;
    }
  EXPECT_GT(bins, 80);
  EXPECT_LT(statistic, bins + 6 * std::sqrt(2.0 * bins));
}

TEST(Environment, TopRowIsUpAndRotationTurnsTheLightCounterClockwise) {
  std::vector<glm::vec3> pixels(64 * 32, glm::vec3(0.0f));
  pixels[0] = glm::vec3(1.0f);
  pixels[16 * 64 + 32] = glm::vec3(3.0f);  // just right of the centre, below the horizon: -y, a little -x
  const Environment still(64, 32, pixels, 0, 1), turned(64, 32, pixels, pi / 2, 1);
  EXPECT_EQ(still.radiance({-0.02f, -0.999f, -0.02f}).r, 3);
  EXPECT_EQ(turned.radiance({0.999f, -0.02f, -0.02f}).r, 3);  // -y turned by 90 degrees about +z is +x
  EXPECT_EQ(still.radiance({0.0005f, 0.02f, 0.9997f}).r, 1);
}

TEST(Environment, BlackMapsAreDrawnUniformly) {
  const Environment black(4, 2, std::vector<glm::vec3>(8, glm::vec3(0.0f)), 0, 1);
  EXPECT_NEAR(black.sample(0.3f, 0.4f).pdf_solid_angle, 1 / (4 * pi), 1e-6);
}

}  // namespace
}  // namespace tress::scene
