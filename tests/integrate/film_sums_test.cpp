// Sums over the pixels of a film.
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <array>

#include "base/color.h"
#include "integrate/film.h"
#include "tress/base/random.h"

namespace tress::integrate {
namespace {

constexpr int width = 130, height = 61;  // three blocks of sums and a piece

Film film_of(int paths) {
  Film film({0, 0, width, height}, false, false, Ground::backdrop, 0, false, {});
  RandomStream random(20261127);
  for (int i = 0; i < paths; ++i) {
    PathSums path;
    path.layers[0] = {random.next(), 2 * random.next(), random.next()};
    path.coverage = 1;
    film.add(static_cast<int>(random.next() * width), static_cast<int>(random.next() * height), path);
  }
  return film;
}

/// Within what the order of 10,000 additions in doubles may change, 1e4 * 2^-53.
TEST(FilmSums, AreThoseOfAllPixelsOneByOne) {
  const Film film = film_of(10000);
  double light = 0, pixels = 0, samples = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const PixelSums& pixel = film.pixel(x, y);
      if (pixel.samples == 0) continue;
      light += luminance(pixel.beauty(Ground::nothing)) / pixel.samples;
      pixels += 1;
      samples += pixel.samples;
    }
  }
  constexpr double rounding = 1e4 * 0x1p-53;
  EXPECT_NEAR(film.brightness() / (light / (width * height)), 1, rounding);
  EXPECT_EQ(film.seen().pixels, pixels);
  EXPECT_EQ(film.seen().samples, samples);
  EXPECT_EQ(samples, 10000);
}

TEST(FilmSums, AreTheSameBitsForAnyNumberOfThreads) {
  const Film film = film_of(10000);
  const auto sums = [&] {
    const Film::Seen seen = film.seen();
    return std::array{film.brightness(), film.relative_noise(), film.excess().value, seen.mean, seen.light_paths};
  };
  const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism, 8);
  const auto alone = tbb::task_arena(1).execute(sums);
  EXPECT_GT(alone[1], 0);
  for (int round = 0; round < 20; ++round) EXPECT_EQ(tbb::task_arena(8).execute(sums), alone);
}

}  // namespace
}  // namespace tress::integrate
