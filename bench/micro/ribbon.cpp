// What a ribbon costs: to ask, to decode, to fit and to test. One node of the rough fiber. CPU time.
#include "tress/adaptive/ribbon.h"

#include <benchmark/benchmark.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "adaptive/learn_samples.h"
#include "convergence/held_out_test.h"
#include "density/interpolated_row.h"
#include "fiber/rough_rows.h"
#include "fit/fitted_row.h"
#include "fit/learn_stage.h"
#include "fit/row_exits.h"
#include "models/rough/colored_decays.h"
#include "models/rough/rough_row.h"
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

void pack_row(benchmark::State& state) {
  std::array<adaptive::RibbonRow::Part, adaptive::RibbonRow::most_parts> parts;
  for (std::uint32_t p = 0; p < parts.size(); ++p) parts[p] = {learned_row().ribbon(p), learned_row().mass(p)};
  for (auto _ : state) benchmark::DoNotOptimize(adaptive::RibbonRow(parts));
}
BENCHMARK(pack_row);

void interpolate(benchmark::State& state) {  // four rows, which are decoded once for many others
  const adaptive::DecodedRow row(learned_row());
  const adaptive::DecodedRow other(
      adaptive::learn_stage(target(), slice(), theta_r + 0.2f, phi_r, 512, 0, nullptr, nullptr).row);
  const std::array<adaptive::WeightedRow, 4> rows{{{&row, 0.3f}, {&other, 0.2f}, {&row, 0.1f}, {&other, 0.4f}}};
  for (auto _ : state) benchmark::DoNotOptimize(adaptive::interpolate_rows(rows));
}
BENCHMARK(interpolate);

void color_row(benchmark::State& state) {
  const adaptive::DecodedRow row(learned_row());
  const fiber::ColoredDecays decays(glm::vec3(0.3f, 0.9f, 4));
  const auto memory = std::make_unique<fiber::RoughRow>();
  for (auto _ : state) benchmark::DoNotOptimize(fiber::put_rough_row(row, 0.01f, 512, decays, {}, memory.get()));
}
BENCHMARK(color_row);

void decode_row(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(adaptive::DecodedRow(learned_row()));
}
BENCHMARK(decode_row);

void sort(benchmark::State& state) {
  const std::vector<adaptive::SampledExit> exits = exits_of(static_cast<std::uint32_t>(state.range(0)), 3);
  for (auto _ : state) benchmark::DoNotOptimize(adaptive::sort_exits(exits, fiber::rough_parts));
}
BENCHMARK(sort)->Arg(512)->Arg(4096)->Unit(benchmark::kMicrosecond);

/// All parts and laws of a row, with decays and energies, packed; of sorted exits.
void fit(benchmark::State& state, const adaptive::RibbonRow* parent) {
  const auto paths = static_cast<std::uint32_t>(state.range(0));
  const adaptive::RowExits exits = adaptive::sort_exits(exits_of(paths, 3), fiber::rough_parts);
  const auto rule = adaptive::RibbonFitRule::of(paths, parent != nullptr, 256);
  for (auto _ : state) {
    adaptive::PartEnergies energies;
    energies.add(exits, paths);
    benchmark::DoNotOptimize(adaptive::fitted_row(exits, energies, parent, rule));
  }
}
void fit_from_moments(benchmark::State& state) { fit(state, nullptr); }
void fit_from_parent(benchmark::State& state) { fit(state, &learned_row()); }
BENCHMARK(fit_from_moments)->Arg(512)->Arg(1024)->Arg(4096)->Arg(16384)->Unit(benchmark::kMicrosecond);
BENCHMARK(fit_from_parent)->Arg(512)->Unit(benchmark::kMicrosecond);

/// A row at a stage, with the draws of all its paths and the test of the stage before.
void stage(benchmark::State& state) {
  const auto paths = static_cast<std::uint32_t>(state.range(0));
  const std::uint32_t paths_before = paths > 512 ? paths / 4 : 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(adaptive::learn_stage(target(), slice(), theta_r, phi_r, paths, paths_before,
                                                   paths_before > 0 ? &learned_row() : nullptr, nullptr));
  }
}
BENCHMARK(stage)->Arg(512)->Arg(2048)->Arg(8192)->Unit(benchmark::kMicrosecond);

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
