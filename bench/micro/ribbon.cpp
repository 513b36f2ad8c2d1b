// What a ribbon costs: to ask, to decode, to fit and to test. One node of the rough fiber. CPU time.
#include "tress/adaptive/ribbon.h"

#include <benchmark/benchmark.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "convergence/held_out_test.h"
#include "fiber/rough_rows.h"
#include "fit/exit_columns.h"
#include "fit/fit_ribbon.h"
#include "fit/sampled_learner.h"
#include "tress/base/random.h"

namespace tress {
namespace {

using adaptive::Ribbon;

constexpr float theta_r = 0.5f, phi_r = 0.4f;

const adaptive::SampledTarget& target() {
  static const auto rough = fiber::make_rough_target();
  return *rough;
}

const adaptive::SliceDescription& slice() {
  static const adaptive::SliceDescription slice = fiber::rough_slice({});
  return slice;
}

std::vector<adaptive::SampledExit> exits_of(std::uint32_t paths, std::uint64_t stream) {
  std::vector<adaptive::SampledExit> exits;
  target().draw(slice(), theta_r, phi_r, stream, 0, paths, exits);
  return exits;
}

const adaptive::RibbonRow& learned_row() {
  static const adaptive::SampledRow learned = adaptive::learn_samples(target(), slice(), theta_r, phi_r, {});
  return learned.row;
}

/// Places that are asked, cycled through.
const std::vector<adaptive::SampledExit>& asked() {
  static const std::vector<adaptive::SampledExit> exits = exits_of(256, 99);
  return exits;
}

template <class Ask>
void ask(benchmark::State& state, Ask&& ask) {
  const Ribbon ribbon = learned_row().ribbon(1);
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(ask(ribbon, asked()[i++ % asked().size()]));
}

void density(benchmark::State& state) {
  ask(state, [](const Ribbon& f, const adaptive::SampledExit& at) { return f.density(at.azimuth, at.height); });
}
BENCHMARK(density);

void cdf(benchmark::State& state) {
  ask(state, [](const Ribbon& f, const adaptive::SampledExit& at) { return f.cdf(at.azimuth, at.height); });
}
BENCHMARK(cdf);

void sample(benchmark::State& state) {
  RandomStream random(1);
  ask(state, [&random](const Ribbon& f, const adaptive::SampledExit&) {
    const float u = random.next();
    return f.sample(u, random.next());
  });
}
BENCHMARK(sample);

void unpack_part(benchmark::State& state) {
  const adaptive::RibbonRow& row = learned_row();
  for (auto _ : state) benchmark::DoNotOptimize(row.ribbon(1));
}
BENCHMARK(unpack_part);

void read_row(benchmark::State& state) {  // as a cache does, with the check of every byte
  const adaptive::RibbonRow& row = learned_row();
  adaptive::RibbonRow read;
  for (auto _ : state) benchmark::DoNotOptimize(read.unpack(row.packed(), row.masses()));
}
BENCHMARK(read_row);

void draw(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(exits_of(static_cast<std::uint32_t>(state.range(0)), 3));
}
BENCHMARK(draw)->Arg(4096)->Unit(benchmark::kMillisecond);

/// All parts from nothing, or from an earlier fit.
void fit(benchmark::State& state, bool from_earlier) {
  const std::vector<adaptive::SampledExit> exits = exits_of(static_cast<std::uint32_t>(state.range(0)), 3);
  const std::vector<adaptive::SampledExit> fewer = exits_of(static_cast<std::uint32_t>(state.range(0) / 2), 3);
  std::vector<Ribbon> earlier;
  for (std::uint32_t p = 0; p < fiber::rough_parts; ++p) {
    earlier.push_back(adaptive::fit_ribbon(adaptive::sort_exits(fewer, p), nullptr, false).ribbon);
  }
  for (auto _ : state) {
    for (std::uint32_t p = 0; p < fiber::rough_parts; ++p) {
      benchmark::DoNotOptimize(
          adaptive::fit_ribbon(adaptive::sort_exits(exits, p), from_earlier ? &earlier[p] : nullptr, false));
    }
  }
}
void first_fit(benchmark::State& state) { fit(state, false); }
void next_fit(benchmark::State& state) { fit(state, true); }
BENCHMARK(first_fit)->Arg(1024)->Unit(benchmark::kMillisecond);
BENCHMARK(next_fit)->Arg(2048)->Arg(4096)->Arg(16384)->Unit(benchmark::kMillisecond);

void test(benchmark::State& state) {
  const auto paths = static_cast<std::uint32_t>(state.range(0));
  const std::vector<adaptive::SampledExit> exits = exits_of(paths, 5);
  for (auto _ : state) {
    adaptive::HeldOutTest held_out(learned_row());
    for (std::size_t s = 0; s < adaptive::HeldOutTest::sets; ++s) {
      held_out.add(s, std::span(exits).subspan(s * exits.size() / 4, exits.size() / 4));
    }
    benchmark::DoNotOptimize(held_out.result(paths / 4));
  }
}
BENCHMARK(test)->Arg(4096)->Unit(benchmark::kMillisecond);

void learn(benchmark::State& state) {
  for (auto _ : state) {
    benchmark::DoNotOptimize(adaptive::learn_samples(target(), slice(), theta_r, phi_r, {}));
  }
}
BENCHMARK(learn)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace tress

BENCHMARK_MAIN();
