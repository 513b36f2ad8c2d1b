#include "scene/model/environment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scene/generate/generated_environments.h"
#include "support/chi_square.h"
#include "tress/base/random.h"

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

/// Pixels that only the top or bottom row lights, and only in two columns.
Environment polar_map(double rotate_rad) {
  std::vector<glm::vec3> pixels(16 * 8, glm::vec3(0.0f));
  pixels[3] = glm::vec3(5.0f);
  pixels[7 * 16 + 9] = glm::vec3(1, 2, 3);
  return Environment(16, 8, std::move(pixels), rotate_rad, 1.0f);
}

/// Seed 11; 2e5 draws of six maps into 16 x 8 bins of the map, found from the direction by elementary geometry; family
/// level 1e-6. A draw in single precision falls into the neighbouring bin once in 1e6.
TEST(Environment, SamplesFollowTheDensityAtThePolesAndTurned) {
  for (const double rotate_rad : {0.0, 1.234, -5.0})
    for (const bool polar : {false, true}) {
      const auto environment = polar ? polar_map(rotate_rad) : uneven_map(rotate_rad);
      constexpr int draws = 200000;
      std::vector<double> seen(128, 0), expected(128, 0);
      RandomStream random(11);
      int strays = 0;
      for (int i = 0; i < draws; ++i) {
        const float u1 = random.next(), u2 = random.next();
        const auto s = environment.sample(u1, u2);
        ASSERT_GT(s.pdf_solid_angle, 0);
        const double down = std::acos(std::clamp(static_cast<double>(s.direction.z), -1.0, 1.0));
        double turns = (std::atan2(-s.direction.x, -s.direction.y) + rotate_rad) / (2 * pi) + 0.5;
        turns -= std::floor(turns);
        const int row = std::min(7, static_cast<int>(down / pi * 8)),
                  column = std::min(15, static_cast<int>(turns * 16));
        // The density is that of the bin that the direction lies in, but for rounding at its edges.
        const double a = 2 * pi * ((column + 0.5) / 16 - 0.5) - rotate_rad, d = pi * (row + 0.5) / 8;
        const glm::vec3 middle(-std::sin(d) * std::sin(a), -std::sin(d) * std::cos(a), std::cos(d));
        strays += environment.pdf_solid_angle(middle) != s.pdf_solid_angle;
        seen[static_cast<std::size_t>(row * 16 + column)] += 1;
      }
      EXPECT_LE(strays, 4);
      for (int row = 0; row < 8; ++row)
        for (int column = 0; column < 16; ++column) {
          const double down = pi * (row + 0.5) / 8, a = 2 * pi * ((column + 0.5) / 16 - 0.5) - rotate_rad;
          const glm::vec3 d(-std::sin(down) * std::sin(a), -std::sin(down) * std::cos(a), std::cos(down));
          const double solid = 2 * pi / 16 * (std::cos(pi * row / 8) - std::cos(pi * (row + 1) / 8));
          expected[static_cast<std::size_t>(row * 16 + column)] = draws * environment.pdf_solid_angle(d) * solid;
        }
      for (std::size_t k = 0; k < seen.size(); ++k)
        if (expected[k] == 0 && seen[k] <= 4) seen[k] = 0;  // the strays
      EXPECT_GT(test::chi_square(seen, expected).p_value, test::sidak_level(1e-6, 6)) << rotate_rad << polar;
    }
}

/// The mean of radiance over density is the integral of the radiance: exact per pixel whatever u. 4096 draws on a
/// grid; a sun of 1e6 in one pixel of a large map and in a corner of the top row.
TEST(Environment, GivesTheWholeEnergyOfASunInOnePixel) {
  for (const std::size_t sun : {std::size_t{5}, std::size_t{300 * 2048 + 1999}}) {
    std::vector<glm::vec3> pixels(2048 * 1024, glm::vec3(0.5f));
    pixels[sun] = glm::vec3(1e6f);
    const Environment environment(2048, 1024, std::move(pixels), 0.7, 1);
    double sum = 0;
    for (int i = 0; i < 64; ++i)
      for (int j = 0; j < 64; ++j) {
        const auto s = environment.sample((i + 0.5f) / 64, (j + 0.5f) / 64);
        sum += s.radiance.g / s.pdf_solid_angle / 4096;
      }
    // Masses are differences of sums in single precision near 1: up to 6 % of a dim pixel in a row with a sun, which
    // is drawn once in a thousand times.
    EXPECT_NEAR(sum / (4 * pi * environment.mean().g), 1, 6e-5) << sun;
  }
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
