// What the closed-form parts of a vertex cost: longitudinal lobe, R, energies. CPU time.
#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "fiber/energy_table.h"
#include "fiber/longitudinal.h"
#include "fiber/reflection.h"
#include "tress/base/random.h"

namespace tress {
namespace {

constexpr std::size_t inputs = 256;  // cycled through: branches are not learned, the cache is

std::array<float, inputs> uniform(float low, float high, std::uint64_t seed) {
  RandomStream random(seed);
  std::array<float, inputs> all;
  for (float& x : all) x = low + (high - low) * random.next();
  return all;
}

void longitudinal_construct_density(benchmark::State& state) {
  const auto known = uniform(-1.5f, 1.5f, 1), sampled = uniform(-1.5f, 1.5f, 2);
  std::size_t i = 0;
  for (auto _ : state) {
    const fiber::LongitudinalLobe lobe(known[i % inputs], 0.0262f, 0.08f);
    benchmark::DoNotOptimize(lobe.density(sampled[i % inputs]));
    ++i;
  }
}
BENCHMARK(longitudinal_construct_density);

void longitudinal_density(benchmark::State& state) {
  const auto sampled = uniform(-1.5f, 1.5f, 2);
  const fiber::LongitudinalLobe lobe(0.3f, 0.0262f, 0.08f);
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(lobe.density(sampled[i++ % inputs]));
}
BENCHMARK(longitudinal_density);

void longitudinal_sample(benchmark::State& state) {
  const auto u = uniform(0, 1, 2);
  const fiber::LongitudinalLobe lobe(0.3f, 0.0262f, 0.08f);
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(lobe.sample(u[i++ % inputs]));
}
BENCHMARK(longitudinal_sample);

// The shapes of the paper's figure 4: a lobe of its own for each sample, and further samples of one lobe, with density.
void shape_first(benchmark::State& state, fiber::LongitudinalShape shape) {
  const auto known = uniform(-1.5f, 1.5f, 1), u = uniform(0, 1, 2);
  std::size_t i = 0;
  for (auto _ : state) {
    const fiber::LongitudinalLobe lobe(known[i % inputs], 0.0262f, 0.08f, shape);
    benchmark::DoNotOptimize(lobe.density(lobe.sample(u[i % inputs])));
    ++i;
  }
}

void shape_next(benchmark::State& state, fiber::LongitudinalShape shape) {
  const auto u = uniform(0, 1, 2);
  const fiber::LongitudinalLobe lobe(0.3f, 0.0262f, 0.08f, shape);
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(lobe.density(lobe.sample(u[i++ % inputs])));
}

void shape_evaluate(benchmark::State& state, fiber::LongitudinalShape shape) {
  const auto known = uniform(-1.5f, 1.5f, 1), sampled = uniform(-1.5f, 1.5f, 2);
  std::size_t i = 0;
  for (auto _ : state) {
    const fiber::LongitudinalLobe lobe(known[i % inputs], 0.0262f, 0.08f, shape);
    benchmark::DoNotOptimize(lobe.density(sampled[i % inputs]));
    ++i;
  }
}
// The Gaussian as the paper draws it: Box and Muller, again until it falls into the hemisphere. First and next alike,
// but for what a lobe takes to be made.
float box_and_muller(RandomStream& random, float theta_r) {
  constexpr float width = 1.497f * 0.08f, tilt = 0.0262f, two_pi = 6.2831853f;
  for (;;) {
    const float z = std::sqrt(-2 * std::log1p(-random.next())) * std::cos(two_pi * random.next());
    const float theta = 2 * (tilt + width * z) - theta_r;
    if (std::abs(theta) < fiber::half_pi) return theta;
  }
}
void shape_first_box_muller(benchmark::State& state) {
  const auto known = uniform(-1.5f, 1.5f, 1);
  RandomStream random(2);
  std::size_t i = 0;
  for (auto _ : state) {
    const float theta_r = known[i++ % inputs];
    const fiber::LongitudinalLobe lobe(theta_r, 0.0262f, 0.08f, fiber::LongitudinalShape::gaussian);
    benchmark::DoNotOptimize(lobe.density(box_and_muller(random, theta_r)));
  }
}
BENCHMARK(shape_first_box_muller);
void shape_next_box_muller(benchmark::State& state) {
  RandomStream random(2);
  const fiber::LongitudinalLobe lobe(0.3f, 0.0262f, 0.08f, fiber::LongitudinalShape::gaussian);
  for (auto _ : state) benchmark::DoNotOptimize(lobe.density(box_and_muller(random, 0.3f)));
}
BENCHMARK(shape_next_box_muller);
BENCHMARK_CAPTURE(shape_first, logistic, fiber::LongitudinalShape::logistic);
BENCHMARK_CAPTURE(shape_first, gaussian, fiber::LongitudinalShape::gaussian);
BENCHMARK_CAPTURE(shape_first, cauchy, fiber::LongitudinalShape::cauchy);
BENCHMARK_CAPTURE(shape_next, logistic, fiber::LongitudinalShape::logistic);
BENCHMARK_CAPTURE(shape_next, gaussian, fiber::LongitudinalShape::gaussian);
BENCHMARK_CAPTURE(shape_next, cauchy, fiber::LongitudinalShape::cauchy);
BENCHMARK_CAPTURE(shape_evaluate, logistic, fiber::LongitudinalShape::logistic);
BENCHMARK_CAPTURE(shape_evaluate, gaussian, fiber::LongitudinalShape::gaussian);
BENCHMARK_CAPTURE(shape_evaluate, cauchy, fiber::LongitudinalShape::cauchy);

void reflection_construct(benchmark::State& state) {
  const auto known = uniform(-1.5f, 1.5f, 1), azimuth = uniform(-3.1f, 3.1f, 3);
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        fiber::ReflectionLobe(1.55f, 0.85f, known[i % inputs], azimuth[i % inputs], 0.1f, -0.05f, 0.08f));
    ++i;
  }
}
BENCHMARK(reflection_construct);

void reflection_evaluate(benchmark::State& state) {
  const auto sampled = uniform(-1.5f, 1.5f, 2), azimuth = uniform(-3.1f, 3.1f, 3);
  const fiber::ReflectionLobe lobe(1.55f, 0.85f, 0.3f, 0.7f, 0.1f, -0.05f, 0.08f);
  std::size_t i = 0;
  for (auto _ : state) {
    const fiber::ReflectionLobe::At at = lobe.at(azimuth[i % inputs]);
    benchmark::DoNotOptimize(lobe.longitudinal_density(at, sampled[i % inputs]) * (at.energy_density + at.azimuth_pdf));
    ++i;
  }
}
BENCHMARK(reflection_evaluate);

void reflection_sample(benchmark::State& state) {
  const auto u = uniform(0, 1, 2);
  const fiber::ReflectionLobe lobe(1.55f, 0.85f, 0.3f, 0.7f, 0.1f, -0.05f, 0.08f);
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(lobe.sample_azimuth(u[i++ % inputs]));
}
BENCHMARK(reflection_sample);

void energies_look_up(benchmark::State& state) {
  const fiber::FiberParameters parameters;
  const fiber::EnergyTable table(std::make_shared<fiber::ClearEnergies>(fiber::energy_key(parameters)), parameters);
  const auto known = uniform(-1.5f, 1.5f, 1), azimuth = uniform(-3.1f, 3.1f, 3);
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(table.at(azimuth[i % inputs], known[i % inputs]));
    ++i;
  }
}
BENCHMARK(energies_look_up);

void energies_of_a_cross_section(benchmark::State& state) {
  const auto e = uniform(0.5f, 1, 4);
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(fiber::ClearEnergies({1.55f, e[i++ % inputs], 0.2f, 0.05f}));
}
BENCHMARK(energies_of_a_cross_section)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();

void energies_of_a_color(benchmark::State& state) {
  const fiber::FiberParameters parameters;
  const auto clear = std::make_shared<const fiber::ClearEnergies>(fiber::energy_key(parameters));
  for (auto _ : state) benchmark::DoNotOptimize(fiber::EnergyTable(clear, parameters));
}
BENCHMARK(energies_of_a_color)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace tress

BENCHMARK_MAIN();
