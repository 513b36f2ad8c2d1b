#include "scene/model/environment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <utility>

#include "scene/generate/generated_environments.h"
#include "support/chi_square.h"
#include "tress/base/random.h"

namespace tress::scene {
namespace {

constexpr double pi = std::numbers::pi;

/// fall: 1 - cos of the angle from +z; azimuth: as in the map, 0 is its centre, -y.
glm::vec3 direction_at(double fall, double azimuth) {
  const double flat = std::sqrt(std::max(0.0, fall * (2 - fall)));
  return {-flat * std::sin(azimuth), -flat * std::cos(azimuth), 1 - fall};
}

/// Through the centre of a pixel.
glm::vec3 centre_of(int row, int column, int width, int height, double rotate_rad = 0) {
  return direction_at(1 - std::cos(pi * (row + 0.5) / height), 2 * pi * ((column + 0.5) / width - 0.5) - rotate_rad);
}

std::vector<glm::vec3> uneven_pixels(int count) {
  RandomStream random(7);
  std::vector<glm::vec3> pixels;
  for (int i = 0; i < count; ++i)
    pixels.push_back(i % 5 == 0 ? glm::vec3(0.0f) : glm::vec3(random.next(), random.next(), 10 * random.next()));
  return pixels;
}

Environment uneven_map(double rotate_rad) { return Environment(16, 8, uneven_pixels(128), rotate_rad, 2.0f); }

/// Pixels that only the top or bottom row lights, and only in two columns.
Environment polar_map(double rotate_rad) {
  std::vector<glm::vec3> pixels(16 * 8, glm::vec3(0.0f));
  pixels[3] = glm::vec3(5.0f);
  pixels[7 * 16 + 9] = glm::vec3(1, 2, 3);
  return Environment(16, 8, std::move(pixels), rotate_rad, 1.0f);
}

Environment edged_sky() { return gradient_environment({{1, 2, 4}, {3, 3, 3}, {0.5f, 0.25f, 0}}, 1); }

/// Midpoints in azimuth and the cosine; the kinks at the rows of the map fall between those of this grid, so 1e-3.
TEST(Environment, DensityIntegratesToOneAndMeanIsTheMean) {
  for (const auto& environment :
       {uneven_map(0.0), uneven_map(2.1), polar_map(0.7), studio_environment(0.3, 1.0f), edged_sky(),
        Environment(glm::vec3(0.5f)), uneven_map(2.1).drawn_by(Environment::Draw::light)}) {
    constexpr int rows = 2000, columns = 512;
    double density = 0, red = 0;
    for (int i = 0; i < rows; ++i)
      for (int j = 0; j < columns; ++j) {
        const glm::vec3 d = direction_at(2 * (i + 0.5) / rows, 2 * pi * (j + 0.5) / columns);
        const Environment::Seen seen = environment.look(d);
        EXPECT_EQ(seen.radiance, environment.radiance(d));
        density += seen.pdf_solid_angle * 4 * pi / (rows * columns);
        red += seen.radiance.r / (1.0 * rows * columns);
      }
    EXPECT_NEAR(density, 1, 1e-3);
    EXPECT_NEAR(red / environment.mean().r, 1, 1e-3);
  }
}

/// Every sample of a grid of u: what it carries is what is seen along its direction, to the rounding of a direction
/// (3e-7 of a map of 16 pixels).
TEST(Environment, SamplesCarryWhatIsSeenAlongThem) {
  for (const auto& environment : {uneven_map(1.234), polar_map(0.0), edged_sky()}) {
    const float scale = environment.mean().b;
    for (int i = 0; i < 128; ++i)
      for (int j = 0; j < 128; ++j) {
        const auto s = environment.sample((i + 0.5f) / 128, (j + 0.25f) / 128);
        const auto seen = environment.look(s.direction);
        ASSERT_GT(s.pdf_solid_angle, 0);
        EXPECT_NEAR(glm::dot(s.direction, s.direction), 1, 1e-6);
        EXPECT_NEAR(s.radiance.b, seen.radiance.b, 3e-4f * scale);
        EXPECT_NEAR(s.pdf_solid_angle, seen.pdf_solid_angle, 3e-4f);
      }
  }
}

/// Seed 11; 2e5 draws of seven maps into 32 x 16 bins that are uniform in azimuth and the cosine, found from the
/// direction by elementary geometry, against 8 x 8 midpoints of the density in each; the midpoint rule is off by less
/// than a tenth of the draws' own error. Family level 1e-6.
TEST(Environment, SamplesFollowTheDensityAtThePolesAcrossTheSeamAndTurned) {
  std::vector<Environment> maps{edged_sky()};
  for (const double rotate_rad : {0.0, 1.234, -5.0}) {
    maps.push_back(uneven_map(rotate_rad));
    maps.push_back(polar_map(rotate_rad));
  }
  for (std::size_t map = 0; map < maps.size(); ++map) {
    constexpr int draws = 200000, rows = 16, columns = 32, fine = 8;
    std::vector<double> seen(rows * columns, 0), expected(rows * columns, 0);
    RandomStream random(11);
    for (int i = 0; i < draws; ++i) {
      const float u1 = random.next(), u2 = random.next();
      const auto s = maps[map].sample(u1, u2);
      double turns = std::atan2(-s.direction.x, -s.direction.y) / (2 * pi) + 1;
      turns -= std::floor(turns);
      const int row = std::clamp(static_cast<int>((1 - s.direction.z) / 2 * rows), 0, rows - 1);
      seen[static_cast<std::size_t>(row * columns + std::min(columns - 1, static_cast<int>(turns * columns)))] += 1;
    }
    for (int row = 0; row < rows * fine; ++row)
      for (int column = 0; column < columns * fine; ++column) {
        const auto d = direction_at(2 * (row + 0.5) / (rows * fine), 2 * pi * (column + 0.5) / (columns * fine));
        expected[static_cast<std::size_t>(row / fine * columns + column / fine)] +=
            draws * maps[map].pdf_solid_angle(d) * 4 * pi / (rows * columns * fine * fine);
      }
    EXPECT_GT(test::chi_square(seen, expected).p_value, test::sidak_level(1e-6, maps.size())) << map;
  }
}

/// By contrast, what is below the mean is drawn by the least weight, 0.02 of the mean, and the rest by what is above
/// it: at the centres of pixels, relative to each other. Nothing that shines has a density of 0.
TEST(Environment, IsDrawnByWhatIsAboveItsMean) {
  constexpr int width = 64, height = 32;
  std::vector<glm::vec3> pixels(width * height, glm::vec3(0.25f));
  for (int column = 0; column < width; ++column)
    pixels[static_cast<std::size_t>(10 * width + column)] = glm::vec3(8.0f);
  pixels[16 * width + 3] = glm::vec3(0.0f);
  const Environment environment(width, height, pixels, 0, 1);
  const float mean = environment.mean().g;
  EXPECT_GT(mean, 0.3f);
  EXPECT_LT(mean, 0.9f);
  const auto density = [&](int row) { return environment.pdf_solid_angle(centre_of(row, 5, width, height)); };
  EXPECT_NEAR(density(10) / density(20), (8 - mean) / (0.02f * mean), 1e-3f * (8 - mean) / (0.02f * mean));
  EXPECT_NEAR(density(20) / density(2), 1, 1e-5f);
  EXPECT_GT(environment.pdf_solid_angle(centre_of(16, 3, width, height)), 0);
  for (const auto& other : {uneven_map(0.3), studio_environment(0.3, 1.0f), edged_sky()}) {
    RandomStream random(17);
    for (int i = 0; i < 10000; ++i) {
      const auto seen = other.look(direction_at(2 * random.next(), 2 * pi * random.next()));
      EXPECT_GT(seen.pdf_solid_angle, 0);
    }
  }
}

/// Grey light is drawn in proportion to itself, if asked: radiance over density is its integral, whatever u. A sun of
/// 1e6 in one pixel of a large map and in a corner of the top row.
TEST(Environment, GivesTheWholeEnergyOfASunInOnePixelWithEverySample) {
  for (const std::size_t sun : {std::size_t{5}, std::size_t{300 * 2048 + 1999}, std::size_t{300 * 2048 + 2047}}) {
    std::vector<glm::vec3> pixels(2048 * 1024, glm::vec3(0.5f));
    pixels[sun] = glm::vec3(1e6f);
    const Environment environment =
        Environment(2048, 1024, std::move(pixels), 0.7, 1).drawn_by(Environment::Draw::light);
    const double whole = 4 * pi * environment.mean().g;
    double integral = 0;  // of the pixels: the bilinear map has their light
    for (int row = 0; row < 1024; ++row)
      integral += 0.5 * 2 * pi * (std::cos(pi * row / 1024) - std::cos(pi * (row + 1) / 1024));
    const auto row = static_cast<double>(sun / 2048);
    integral += (1e6 - 0.5) * 2 * pi / 2048 * (std::cos(pi * row / 1024) - std::cos(pi * (row + 1) / 1024));
    EXPECT_NEAR(whole / integral, 1, sun < 2048 ? 0.4 : 1e-3) << sun;  // of the top row's pixels the pole has the mean
    for (int i = 0; i < 64; ++i)
      for (int j = 0; j < 64; ++j) {
        const auto s = environment.sample((i + 0.5f) / 64, (j + 0.5f) / 64);
        EXPECT_NEAR(s.radiance.g / s.pdf_solid_angle / whole, 1, 1e-5) << sun;
      }
  }
}

/// Seed 5; 65536 draws of colored maps: the mean of radiance over density is the integral, within 5 of its own standard
/// errors, which is less than one false alarm in 200,000 of the 9 comparisons.
TEST(Environment, MeanOfRadianceOverDensityIsTheIntegral) {
  for (const auto& environment : {uneven_map(0.4), polar_map(3.0), studio_environment(1, 1)}) {
    constexpr int draws = 65536;
    glm::dvec3 sum(0.0), squares(0.0);
    RandomStream random(5);
    for (int i = 0; i < draws; ++i) {
      const float u1 = random.next(), u2 = random.next();
      const auto s = environment.sample(u1, u2);
      const glm::dvec3 value = glm::dvec3(s.radiance) / static_cast<double>(s.pdf_solid_angle) / (4 * pi);
      sum += value;
      squares += value * value;
    }
    for (int c = 0; c < 3; ++c) {
      const double mean = sum[c] / draws, error = std::sqrt((squares[c] / draws - mean * mean) / draws);
      EXPECT_NEAR(mean, environment.mean()[c], 5 * error + 1e-6 * mean);
    }
  }
}

TEST(Environment, TopRowIsUpAndRotationTurnsTheLightCounterClockwise) {
  std::vector<glm::vec3> pixels(64 * 32, glm::vec3(0.0f));
  pixels[0] = glm::vec3(1.0f);
  pixels[16 * 64 + 32] = glm::vec3(3.0f);  // just right of the centre, below the horizon: -y, a little -x
  const Environment still(64, 32, pixels, 0, 1), turned(64, 32, pixels, pi / 2, 1);
  const glm::vec3 d = centre_of(16, 32, 64, 32);
  EXPECT_LT(d.x, 0);
  EXPECT_LT(d.z, 0);
  EXPECT_NEAR(still.radiance(d).r, 3, 1e-4);
  EXPECT_NEAR(turned.radiance({-d.y, d.x, d.z}).r, 3, 1e-4);  // -y turned by 90 degrees about +z is +x
  EXPECT_NEAR(still.radiance(centre_of(0, 0, 64, 32)).r, 1, 1e-4);
}

/// The centres of pixels show them, and half way between two is their mean, round the seam and in lower rows too.
TEST(Environment, IsBilinearBetweenTheCentresOfItsPixels) {
  const std::vector<glm::vec3> pixels = uneven_pixels(128);
  const Environment map(16, 8, pixels, 0, 1);
  const auto pixel = [&](int row, int column) { return pixels[static_cast<std::size_t>(row * 16 + column % 16)]; };
  for (int row = 0; row < 8; ++row)
    for (int column = 0; column < 16; ++column) {
      EXPECT_NEAR(map.radiance(centre_of(row, column, 16, 8)).b, pixel(row, column).b, 1e-4);
      const double fall = 1 - std::cos(pi * (row + 0.5) / 8), between = 2 * pi * ((column + 1.0) / 16 - 0.5);
      EXPECT_NEAR(map.radiance(direction_at(fall, between)).b, (pixel(row, column).b + pixel(row, column + 1).b) / 2,
                  1e-4);
      if (row == 7) continue;
      const double below = 1 - std::cos(pi * (row + 1.5) / 8), at = 2 * pi * ((column + 0.5) / 16 - 0.5);
      EXPECT_NEAR(map.radiance(direction_at((fall + below) / 2, at)).b,
                  (pixel(row, column).b + pixel(row + 1, column).b) / 2, 1e-4);
    }
}

/// Two directions that are near each other never see much different light: round both poles, along the seam, on the
/// edges between rows. 1e-4 rad is 1/4000 of a pixel; the steepest pixel changes by 20 of one pixel.
TEST(Environment, IsContinuousAtThePolesAndAcrossTheSeam) {
  const Environment map = uneven_map(0);
  for (int i = 0; i < 720; ++i) {
    const double turn = pi * i / 360;
    for (const double pole : {1e-9, 2 - 1e-9}) {
      EXPECT_NEAR(map.radiance(direction_at(pole, turn)).b, map.radiance(direction_at(pole, turn + 2.5)).b, 0.01);
    }
    const double fall = (i + 0.5) / 360;
    EXPECT_NEAR(map.radiance(direction_at(fall, pi - 5e-5)).b, map.radiance(direction_at(fall, pi + 5e-5)).b, 0.01);
    for (int row = 0; row < 8; ++row) {
      const double down = pi * (row + 0.5) / 8;
      EXPECT_NEAR(map.radiance(direction_at(1 - std::cos(down - 5e-5), turn)).b,
                  map.radiance(direction_at(1 - std::cos(down + 5e-5), turn)).b, 0.01);
    }
  }
}

/// A board of one pixel: as seen by a pixel that is as wide as 64 of it, it is grey, at any place; by a narrow one it
/// is what every other look shows. Coarser copies keep the mean of the pixels.
TEST(Environment, ABackdropFinerThanThePictureIsFiltered) {
  std::vector<glm::vec3> pixels;
  for (int row = 0; row < 256; ++row)
    for (int column = 0; column < 512; ++column) pixels.emplace_back((row + column) % 2 == 0 ? 0.0f : 2.0f);
  const Environment board(512, 256, pixels, 0, 1);
  const auto pixel = static_cast<float>(pi / 256);
  RandomStream random(3);
  for (int i = 0; i < 1000; ++i) {
    const double fall = 2 * random.next(), azimuth = 2 * pi * random.next();
    const glm::vec3 d = direction_at(fall, azimuth);
    EXPECT_NEAR(board.backdrop(d, 64 * pixel).r, 1, 0.01);
    EXPECT_NEAR(board.backdrop(d, 4 * pixel).r, 1, 0.01);
    EXPECT_EQ(board.backdrop(d, pixel), board.radiance(d));
  }
}

TEST(Environment, BlackMapsAreDrawnUniformly) {
  const Environment black(4, 2, std::vector<glm::vec3>(8, glm::vec3(0.0f)), 0, 1);
  EXPECT_NEAR(black.sample(0.3f, 0.4f).pdf_solid_angle, 1 / (4 * pi), 1e-6);
  EXPECT_NEAR(black.pdf_solid_angle({0, 0, 1}), 1 / (4 * pi), 1e-6);
}

/// Odd sizes, a single column, a single row.
TEST(Environment, TakesMapsOfAnySize) {
  for (const auto& [width, height] : {std::pair{1, 1}, {1, 7}, {5, 1}, {5, 3}, {6, 3}}) {
    const Environment map(width, height, std::vector<glm::vec3>(static_cast<std::size_t>(width * height), glm::vec3(2)),
                          0, 1);
    for (const float u : {0.0f, 0.3f, 0.9999999f}) {
      const auto s = map.sample(u, 1 - u - 1e-7f);
      EXPECT_NEAR(s.radiance.g, 2, 1e-6);
      EXPECT_NEAR(s.pdf_solid_angle, 1 / (4 * pi), 1e-6);
      EXPECT_NEAR(map.backdrop(s.direction, 1).g, 2, 1e-6);
    }
  }
}

}  // namespace
}  // namespace tress::scene
