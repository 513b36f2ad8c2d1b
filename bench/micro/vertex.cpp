// What the BCSDF of one vertex costs: begin, sample (with S and Q there) and one evaluation for a light.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "models/learned_model.h"

namespace tress {
namespace {

using fiber::FiberDirection;
using fiber::FiberEvent;
using test::LearnedModel;
using test::Rows;

// known direction fixed, xi at random: the rows met are few and stay in the cache, as for a curl lit alike.
void vertex(benchmark::State& state, Rows rows, const glm::vec3& sigma_a) {
  fiber::FiberParameters parameters;
  parameters.sigma_a = sigma_a;
  const FiberDirection known{0.3f, 0.7f};
  const auto model = test::model_in(rows, parameters, known, false);
  RandomStream random(1);
  double queries = 0, exact = 0;
  for (auto _ : state) {
    const float xi1 = random.next(), xi2 = random.next();
    const FiberEvent event = model->begin(known, xi1, xi2);
    const auto sample = model->model().sample(event, {random.next(), random.next(), random.next(), random.next()});
    const auto light = model->model().evaluate(event, {2.5f * (random.next() - 0.5f), 6.28f * (random.next() - 0.5f)});
    benchmark::DoNotOptimize(sample);
    benchmark::DoNotOptimize(light);
    queries += sample.value.queries + light.queries;
    exact += sample.value.exact_queries + light.exact_queries;
  }
  state.counters["exact_share"] = queries > 0 ? exact / queries : 0;
}

// Known directions all over the sphere: hundreds of rows, as deep in a groom. Taught once, 48 directions converged.
void scattered(benchmark::State& state, fiber::Estimator estimator) {
  constexpr int directions = 48;
  RandomStream random(1);
  std::vector<FiberDirection> known;
  for (int i = 0; i < directions; ++i) {
    known.push_back({std::asin(1.9f * (random.next() - 0.5f)), 6.28f * (random.next() - 0.5f)});
  }
  static const std::unique_ptr<LearnedModel> taught = [&] {
    auto model = std::make_unique<LearnedModel>(fiber::FiberParameters{}, fiber::Estimator::fitted);
    for (int round = 0; round < 10; ++round) {
      for (const FiberDirection& wr : known) model->teach(wr, 1, 1000, static_cast<std::uint64_t>(round), false);
    }
    return model;
  }();
  taught->read_by(estimator);
  double queries = 0, exact = 0;
  std::size_t next = 0;
  for (auto _ : state) {
    const FiberEvent event = taught->begin(known[next++ % directions], random.next(), random.next());
    const auto sample = taught->model().sample(event, {random.next(), random.next(), random.next(), random.next()});
    const auto light = taught->model().evaluate(event, {2.5f * (random.next() - 0.5f), 6.28f * (random.next() - 0.5f)});
    benchmark::DoNotOptimize(sample);
    benchmark::DoNotOptimize(light);
    queries += sample.value.queries + light.queries;
    exact += sample.value.exact_queries + light.exact_queries;
  }
  state.counters["exact_share"] = queries > 0 ? exact / queries : 0;
}

// Start-up and memory of a scene of n fibers: e in 16 steps, and as many colors as fibers.
void start_up(benchmark::State& state) {
  const auto target = fiber::make_elliptical_target();
  std::size_t bytes = 0;
  for (auto _ : state) {
    adaptive::Service service(adaptive::Options{}, *target);
    const auto model = *fiber::make_elliptical_model(fiber::Estimator::fitted, &service);
    for (int i = 0; i < state.range(0); ++i) {
      fiber::FiberParameters fiber;
      fiber.eccentricity = 0.85f - 0.01f * static_cast<float>(i % 16);
      fiber.sigma_a *= 1 + 1e-4f * static_cast<float>(i);
      model->add_fiber(fiber);
    }
    bytes = model->bytes();
  }
  state.counters["MB"] = static_cast<double>(bytes) * 1e-6;
}

// The energies of the n shapes that the strands of one material take: e in 50 steps, roughness in degrees.
void start_up_shapes(benchmark::State& state) {
  const auto count = static_cast<int>(state.range(0));
  for (auto _ : state) {
    const auto model = *fiber::make_elliptical_model(fiber::Estimator::exact, nullptr);
    for (int i = 0; i < count; ++i) {
      fiber::FiberParameters fiber;
      fiber.eccentricity = 0.99f - 0.01f * static_cast<float>(i % 50);
      fiber.roughness = static_cast<float>(8 + i / 50) * 0.0174533f;
      fiber.energy_path_share = std::clamp(8 / static_cast<float>(count), 0.125f, 1.0f);
      benchmark::DoNotOptimize(model->add_fiber(fiber));
    }
  }
}

const glm::vec3 clear(0.0f), brown(0.545f, 0.906f, 1.781f);
BENCHMARK_CAPTURE(vertex, converged_brown, Rows::converged, brown);
BENCHMARK_CAPTURE(vertex, converged_clear, Rows::converged, clear);
BENCHMARK_CAPTURE(vertex, open_brown, Rows::open, brown);
BENCHMARK_CAPTURE(vertex, unborn_brown, Rows::absent, brown);
BENCHMARK_CAPTURE(vertex, exact_brown, Rows::traced_at_vertex, brown);
BENCHMARK_CAPTURE(scattered, fitted, fiber::Estimator::fitted);
BENCHMARK_CAPTURE(scattered, corrected, fiber::Estimator::corrected);
BENCHMARK(start_up)->Arg(1)->Arg(100)->Arg(1000)->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK(start_up_shapes)
    ->Arg(1)
    ->Arg(16)
    ->Arg(1000)
    ->Unit(benchmark::kMillisecond)
    ->Iterations(1)
    ->MeasureProcessCPUTime();

}  // namespace
}  // namespace tress

BENCHMARK_MAIN();
