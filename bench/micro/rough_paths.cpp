// What a split path through a rough fiber costs, followed alone and beside others: "ns" is that of one path. The
// argument is a row of `fibers`; TRESS_TARGETS=N in the environment leaves out Highway's targets of the bits N (128:
// AVX-512).
#include "fiber/rough_paths.h"

#include <benchmark/benchmark.h>
#include <hwy/targets.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <numbers>
#include <vector>

#include "base/sobol.h"
#include "fiber/rough_fiber.h"
#include "tress/base/random.h"

namespace tress {
namespace {

constexpr float degree = std::numbers::pi_v<float> / 180;

struct Fiber {
  float eccentricity, alpha, theta, tilt;
  fiber::TracedParts parts{};
};
constexpr std::array<Fiber, 9> fibers{{{0.75f, 0.2f, 30, 3},
                                       {0.5f, 0.05f, 60, 3},
                                       {0.85f, 0.1f, -60, 3},
                                       {1, 0.3f, 0, 3},
                                       {0.75f, 0.3f, 80, 0},
                                       {0.6f, 0.1f, 0, 3},
                                       {0.75f, 0.2f, 30, 3, {0.5f, 2, 0.4f, 0}},
                                       {0.75f, 0.2f, 30, 3, {0.7f, 10, 0.4f, 0}},
                                       {0.75f, 0.2f, 30, 3, {0.85f, 30, 0.4f, 0}}}};
constexpr std::uint32_t paths = 4096;

fiber::FiberParameters parameters_of(const Fiber& shape) {
  fiber::FiberParameters parameters;
  parameters.eccentricity = shape.eccentricity;
  parameters.roughness = shape.alpha;
  parameters.tilt = shape.tilt * degree;
  shape.parts.give_to(parameters);
  return parameters;
}

void add_counters(benchmark::State& state, std::size_t exits) {
  const auto all = static_cast<double>(state.iterations()) * paths;
  state.counters["a_path"] = benchmark::Counter(all, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  state.counters["exits"] = static_cast<double>(exits) / all;
}

void scalar(benchmark::State& state) {
  const Fiber& shape = fibers.at(static_cast<std::size_t>(state.range(0)));
  const fiber::RoughFiber rough(parameters_of(shape));
  const ScrambledSobol points(1);
  std::vector<fiber::SplitExit> exits;
  std::size_t all = 0;
  for (auto _ : state) {
    exits.clear();
    for (std::uint32_t i = 0; i < paths; ++i) {
      const ScrambledSobol::Point u = points.point(i);
      RandomStream random(1, i);
      rough.trace_split(rough.entry({shape.theta * degree, 0.7f}, 2 * u[0] - 1),
                        {{{u[1], u[2]}, {u[3], u[4]}, {u[5], u[6]}}}, random, exits, {0.25f, 1e30f});
    }
    benchmark::DoNotOptimize(exits.data());
    all += exits.size();
  }
  add_counters(state, all);
}
BENCHMARK(scalar)->DenseRange(0, fibers.size() - 1);

/// range(1): paths at a time.
void lanes(benchmark::State& state) {
  const Fiber& shape = fibers.at(static_cast<std::size_t>(state.range(0)));
  std::size_t all = 0;
  for (auto _ : state) {
    const auto at_once = static_cast<std::uint32_t>(state.range(1));
    for (std::uint32_t first = 0; first < paths; first += at_once) {
      fiber::RoughPaths traced(parameters_of(shape), {0.25f, 1e30f});
      traced.add_sobol({shape.theta * degree, 0.7f}, 1, first, at_once, 0);
      all += traced.trace().size();
    }
  }
  add_counters(state, all);
}
BENCHMARK(lanes)->ArgsProduct({benchmark::CreateDenseRange(0, fibers.size() - 1, 1), {paths, 512, 128}});

}  // namespace
}  // namespace tress

int main(int argc, char** argv) {
  if (const char* left_out = std::getenv("TRESS_TARGETS")) hwy::DisableTargets(std::strtoll(left_out, nullptr, 0));
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
