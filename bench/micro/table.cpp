// What the parts of the table cost: g of a traced node, its layout, a look-up, a fit.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <vector>

#include "fit/fit_mixture.h"
#include "observations/sketch.h"
#include "tress/adaptive/service.h"
#include "tress/base/random.h"
#include "tress/fiber/elliptical_model.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr float degree = std::numbers::pi_v<float> / 180;

std::vector<TracedRay> rays_of(int p, float sigma_deg) {
  const SliceDescription slice = fiber::elliptical_slice(p, 1.55f, 0.85f, sigma_deg * degree);
  std::vector<TracedRay> rays;
  fiber::make_elliptical_target()->trace(slice, 0.8f, 0.5f, rays);
  return rays;
}

float azimuth(RandomStream& random) { return 2 * std::numbers::pi_v<float> * (random.next() - 0.5f); }

/// "near" counts the rays within six sigma of the azimuth asked.
void density(benchmark::State& state) {
  const auto sigma = static_cast<float>(state.range(0));
  const TracedNodes nodes(rays_of(2, sigma), sigma * degree);
  RandomStream random(1);
  std::vector<float> asked(1024);
  double near = 0;
  for (float& x : asked) {
    x = azimuth(random);
    for (const float a : nodes.azimuth()) near += std::abs(std::remainder(a - x, 6.2831853f)) < 6 * sigma * degree;
  }
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(nodes.density(asked[i++ % asked.size()]));
  state.counters["rays"] = static_cast<double>(nodes.size());
  state.counters["near"] = near / static_cast<double>(asked.size());
}
BENCHMARK(density)->Arg(5)->Arg(10)->Arg(20);

void traced_nodes(benchmark::State& state) {
  const auto sigma = static_cast<float>(state.range(0));
  const std::vector<TracedRay> rays = rays_of(2, sigma);
  for (auto _ : state) benchmark::DoNotOptimize(TracedNodes(rays, sigma * degree).variation());
}
BENCHMARK(traced_nodes)->Arg(5)->Arg(10)->Arg(20);

void traced(benchmark::State& state) {
  const auto sigma = static_cast<float>(state.range(0));
  for (auto _ : state) benchmark::DoNotOptimize(rays_of(2, sigma).data());
}
BENCHMARK(traced)->Arg(5)->Arg(20);

/// A cold fit of `range(0)` pairs at sigma 10 degrees, epsilon 1/range(1).
void fit(benchmark::State& state) {
  const TracedNodes nodes(rays_of(2, 10), 10 * degree);
  Sketch sketch(Sketch::bin_count(10 * degree));
  RandomStream random(3);
  for (const float x : gap_fill_azimuths({}, 10 * degree)) sketch.offer(x, nodes.density(x));
  while (sketch.occupied() < state.range(0)) {
    const float x = azimuth(random);
    sketch.offer(x, nodes.density(x));
  }
  const std::vector<ObservedPair> pairs = sketch.pairs();
  const FitSettings settings{1.0 / static_cast<double>(state.range(1)), 8};
  Fit result;
  for (auto _ : state) {
    benchmark::DoNotOptimize(result = fit_mixture(pairs, nodes.energy(), nodes.variation(), nullptr, settings));
  }
  state.counters["components"] = result.mixture.component_count;
}
BENCHMARK(fit)->Args({64, 100})->Args({96, 1000});

void attributes(benchmark::State& state) {
  const auto sigma = static_cast<float>(state.range(0));
  const TracedNodes nodes(rays_of(2, sigma), sigma * degree);
  Sketch sketch(Sketch::bin_count(sigma * degree));
  RandomStream random(3);
  for (int i = 0; i < 200; ++i) {
    const float x = azimuth(random);
    sketch.offer(x, nodes.density(x));
  }
  Mixture fit = fit_mixture(sketch.pairs(), nodes.energy(), nodes.variation(), nullptr, {}).mixture;
  for (auto _ : state) {
    assign_attributes(fit, nodes);
    benchmark::DoNotOptimize(fit);
  }
}
BENCHMARK(attributes)->Arg(5)->Arg(20);

/// Converged rows of one slice asked at random: range(0) nodes a side.
void look_up(benchmark::State& state) {
  class Flat final : public Target {
   public:
    void trace(const SliceDescription&, float a, float b, std::vector<TracedRay>& out) const override {
      for (int i = 0; i < 64; ++i) out.push_back({0.1f * static_cast<float>(i) + a + b, 1e-3f / 64, 1});
    }
    std::string model_name() const override { return "flat"; }
  };
  const Flat target;
  Options options;
  options.memory_bytes = std::size_t{2} << 30;
  Service service(options, target);
  SliceDescription slice;
  slice.blur_rad = 0.3f;
  const auto side = static_cast<std::uint32_t>(state.range(0));
  for (std::uint32_t i = 0; i < side; ++i) {
    slice.axis_a.push_back(static_cast<float>(i) * 1e-3f);
    slice.axis_b.push_back(static_cast<float>(i) * 1e-3f);
  }
  const SliceId id = *service.add_slice(slice);
  PassReport report;
  while (report.rows_converged < slice.node_count()) {
    for (std::uint32_t n = 0; n < slice.node_count(); ++n) {
      for (int k = 0; k < 8; ++k) service.look_up(id, n / side, n % side);
    }
    report = service.publish();
  }
  RandomStream random(5);
  for (auto _ : state) {
    const std::uint64_t bits = random.next_bits();
    const auto a = static_cast<std::uint32_t>((bits & 0xffffffffu) * side >> 32);
    const auto b = static_cast<std::uint32_t>((bits >> 32) * side >> 32);
    const RowView row = service.look_up(id, a, b);
    benchmark::DoNotOptimize(row.state);
    benchmark::DoNotOptimize(row.fit->uniform_weight);
  }
  state.counters["bytes_a_row"] = static_cast<double>(report.bytes) / slice.node_count();
}
BENCHMARK(look_up)->Arg(20)->Arg(100)->Arg(400);

}  // namespace
}  // namespace tress::inline v0_2::adaptive

BENCHMARK_MAIN();
