// What light from everywhere costs: a look along a direction with its density, a draw, a look of the camera.
#include "scene/model/environment.h"

#include <benchmark/benchmark.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "tress/base/random.h"

namespace {

using tress::scene::Environment;

/// A sky with a sun, of 2 `height` x `height` pixels.
const Environment& map_of(int height) {
  static int made = 0;
  static Environment environment;
  if (made != height) {
    std::vector<glm::vec3> pixels;
    for (int row = 0; row < height; ++row)
      for (int column = 0; column < 2 * height; ++column)
        pixels.emplace_back(row * 3 == height ? (column == height ? 1e4f : 1.0f)
                                              : 0.5f + 0.4f * std::sin(0.1f * float(column)));
    environment = Environment(2 * height, height, std::move(pixels), 0.3, 1);
    made = height;
  }
  return environment;
}

std::vector<glm::vec3> directions() {
  std::vector<glm::vec3> all;
  tress::RandomStream random(1);
  for (int i = 0; i < 4096; ++i) {
    const float z = 2 * random.next() - 1, turn = 2 * std::numbers::pi_v<float> * random.next();
    const float flat = std::sqrt(1 - z * z);
    all.emplace_back(flat * std::cos(turn), flat * std::sin(turn), z);
  }
  return all;
}

void look(benchmark::State& state) {
  const Environment& map = map_of(int(state.range(0)));
  const std::vector<glm::vec3> all = directions();
  std::size_t i = 0;
  for (auto _ : state) {
    const auto seen = map.look(all[i++ & 4095]);
    benchmark::DoNotOptimize(seen);
  }
}

void radiance(benchmark::State& state) {
  const Environment& map = map_of(int(state.range(0)));
  const std::vector<glm::vec3> all = directions();
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(map.radiance(all[i++ & 4095]));
}

void backdrop(benchmark::State& state) {
  const Environment& map = map_of(int(state.range(0)));
  const std::vector<glm::vec3> all = directions();
  const float footprint = 5 * std::numbers::pi_v<float> / float(state.range(0));
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(map.backdrop(all[i++ & 4095], footprint));
}

void draw(benchmark::State& state) {
  const Environment& map = map_of(int(state.range(0)));
  tress::RandomStream random(2);
  for (auto _ : state) {
    const float u1 = random.next(), u2 = random.next();
    benchmark::DoNotOptimize(map.sample(u1, u2));
  }
}

}  // namespace

BENCHMARK(look)->Arg(128)->Arg(1024);
BENCHMARK(radiance)->Arg(128)->Arg(1024);
BENCHMARK(backdrop)->Arg(128)->Arg(1024);
BENCHMARK(draw)->Arg(128)->Arg(1024);

BENCHMARK_MAIN();
