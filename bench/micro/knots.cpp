// A knot table beside a mixture: what it costs to make one, and to read a converged row of either kind in color.
#include <benchmark/benchmark.h>

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <numbers>
#include <vector>

#include "models/absorbed_row_pool.h"
#include "references/learners/absorbed_knots.h"
#include "references/learners/fit_knots.h"
#include "tress/adaptive/traced_nodes.h"
#include "tress/base/random.h"
#include "tress/fiber/elliptical_model.h"

namespace tress {
namespace {

constexpr float pi = std::numbers::pi_v<float>, degree = pi / 180;
const glm::vec3 brown(0.545f, 0.906f, 1.781f), mix(0.5f, 0.3f, 0.2f);

adaptive::TracedNodes nodes_of(int p, float sigma_deg) {
  const adaptive::SliceDescription slice = fiber::elliptical_slice(p, 1.55f, 0.85f, sigma_deg * degree);
  std::vector<adaptive::TracedRay> rays;
  fiber::make_elliptical_target()->trace(slice, 0.8f, 0.5f, rays);
  return adaptive::TracedNodes(rays, sigma_deg * degree);
}

/// Sigma range(0) degrees, epsilon 1/range(1).
void fit(benchmark::State& state) {
  const adaptive::TracedNodes nodes = nodes_of(2, static_cast<float>(state.range(0)));
  adaptive::KnotFit made;
  for (auto _ : state) {
    benchmark::DoNotOptimize(made = adaptive::fit_knots(nodes, 1.0 / static_cast<double>(state.range(1))));
  }
  state.counters["knots"] = static_cast<double>(made.table.knots().size());
}
BENCHMARK(fit)->Args({20, 100})->Args({10, 100})->Args({5, 100})->Args({5, 1000});

void attributes(benchmark::State& state) {
  const adaptive::TracedNodes nodes = nodes_of(2, static_cast<float>(state.range(0)));
  const adaptive::KnotDensity table = adaptive::fit_knots(nodes, 0.01).table;
  for (auto _ : state) benchmark::DoNotOptimize(adaptive::with_attributes(table, nodes));
}
BENCHMARK(attributes)->Arg(20)->Arg(5);

adaptive::Mixture mixture_of(std::uint32_t components, RandomStream& random) {
  adaptive::Mixture mixture;
  mixture.component_count = components;
  for (std::uint32_t d = 0; d < components; ++d) {
    mixture.components[d] = {
        {2 * pi * (random.next() - 0.5f), 0.05f + 0.2f * random.next(), 0.05f + 0.2f * random.next()},
        0.5f / static_cast<float>(components),
        1 + random.next(),
        0.1f};
  }
  mixture.uniform_weight = 0.01f;
  return mixture;
}

adaptive::KnotDensity table_of(std::size_t count, RandomStream& random) {
  const adaptive::Mixture like = mixture_of(2, random);
  std::vector<adaptive::Knot> knots(count);
  for (std::size_t k = 0; k < count; ++k) {
    const float x = -pi + 2 * pi * static_cast<float>(k) / static_cast<float>(count);
    knots[k] = {like.density(x), 1 + random.next(), 0.1f};
  }
  return adaptive::KnotDensity(knots);
}

/// range(0) rows read in turn, of range(1) components each.
class MixtureRows {
 public:
  explicit MixtureRows(const benchmark::State& state) {
    RandomStream random(4);
    for (std::int64_t i = 0; i < state.range(0); ++i)
      rows_.push_back(pool_.make(mixture_of(static_cast<std::uint32_t>(state.range(1)), random), 0, brown));
  }
  const fiber::AbsorbedRow& pick(RandomStream& random) const {
    return *rows_[static_cast<std::size_t>((random.next_bits() >> 32) * rows_.size() >> 32)];
  }
  double bytes_a_row() const { return static_cast<double>(pool_.bytes()) / static_cast<double>(rows_.size()); }

 private:
  fiber::AbsorbedRowPool pool_;
  std::vector<const fiber::AbsorbedRow*> rows_;
};

/// The same with range(1) knots each.
class KnotRows {
 public:
  explicit KnotRows(const benchmark::State& state) {
    RandomStream random(4);
    for (std::int64_t i = 0; i < state.range(0); ++i)
      rows_.emplace_back(table_of(static_cast<std::size_t>(state.range(1)), random), brown);
  }
  const fiber::AbsorbedKnots& pick(RandomStream& random) const {
    return rows_[static_cast<std::size_t>((random.next_bits() >> 32) * rows_.size() >> 32)];
  }
  double bytes_a_row() const { return static_cast<double>(rows_.front().bytes()); }

 private:
  std::vector<fiber::AbsorbedKnots> rows_;
};

/// Runs `loop` on rows of mixtures, or of knots where range(1) is 32 or more.
template <class Loop>
void on_rows(benchmark::State& state, const Loop& loop) {
  const auto run = [&](const auto& rows) {
    loop(rows);
    state.counters["bytes_a_row"] = rows.bytes_a_row();
  };
  if (state.range(1) >= adaptive::KnotDensity::fewest)
    run(KnotRows(state));
  else
    run(MixtureRows(state));
}

void evaluate(benchmark::State& state) {
  on_rows(state, [&](const auto& rows) {
    RandomStream random(5);
    for (auto _ : state) {
      const auto& row = rows.pick(random);
      benchmark::DoNotOptimize(row.evaluate(2 * pi * (random.next() - 0.5f), mix, 0.02f));
    }
  });
}

void sample(benchmark::State& state) {
  on_rows(state, [&](const auto& rows) {
    RandomStream random(6);
    for (auto _ : state) {
      const auto& row = rows.pick(random);
      benchmark::DoNotOptimize(row.sample(random.next(), mix, 0.02f));
    }
  });
}

/// What the loops above cost by themselves.
void choose(benchmark::State& state) {
  const MixtureRows rows(state);
  RandomStream random(6);
  for (auto _ : state) {
    benchmark::DoNotOptimize(&rows.pick(random));
    benchmark::DoNotOptimize(random.next());
  }
}

void of_every_kind(benchmark::internal::Benchmark* bench) {
  for (const int rows : {64, 16384}) {
    for (const int parts : {1, 2, 4, 8, 32, 64, 128}) bench->Args({rows, parts});
  }
}
BENCHMARK(evaluate)->Apply(of_every_kind);
BENCHMARK(sample)->Apply(of_every_kind);
BENCHMARK(choose)->Args({64, 2})->Args({16384, 2});

}  // namespace
}  // namespace tress

BENCHMARK_MAIN();
