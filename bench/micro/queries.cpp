// What a query of a converged row costs a host: draw, density and density of the draw, by look_up(), as a whole, and
// from C one by one and in batches. 20 x 20 rows of two peaks, asked at random; times are per query.
#include <benchmark/benchmark.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "adaptive/toy_target.h"
#include "tress/adaptive/query.h"
#include "tress/base/random.h"
#include "tress/tress.h"

namespace tress::bench {
namespace {

constexpr std::uint32_t side = 20;
constexpr std::size_t count = 4096;

struct Queries {
  std::vector<adaptive::Node> nodes;
  std::vector<std::array<float, 3>> u;
  std::vector<tress_node> c_nodes;
  Queries() {
    RandomStream random(5);
    for (std::size_t i = 0; i < count; ++i) {
      const auto a = static_cast<std::uint32_t>(random.next() * side),
                 b = static_cast<std::uint32_t>(random.next() * side);
      nodes.push_back({0, a, b});
      c_nodes.push_back({0, a, b});
      u.push_back({random.next(), random.next(), random.next()});
    }
  }
};
const Queries queries;

adaptive::Service& learned() {
  static const testing::MovingPeaks peaks;
  static adaptive::Service service({}, peaks);
  static const bool is_ready = [] {
    const adaptive::SliceId slice = *service.add_slice(testing::toy_slice(0, side));
    while (service.publish().rows_converged < side * side) {
      for (std::uint32_t node = 0; node < side * side; ++node) {
        RandomStream random(3, node);
        for (int i = 0; i < 40; ++i) sample(service, {slice, node / side, node % side}, {random.next(), 0, 0});
      }
    }
    return true;
  }();
  benchmark::DoNotOptimize(is_ready);
  return service;
}

tress_service* learned_in_c() {
  static tress_service* service = [] {
    tress_service* made = nullptr;
    const auto trace = [](void*, const tress_place* place, tress_rays* rays) {
      std::vector<adaptive::TracedRay> found;
      testing::MovingPeaks().trace(testing::toy_slice(0, side), place->a, place->b, found);
      for (const adaptive::TracedRay& one : found) {
        const tress_ray ray{one.azimuth, one.weight, one.attribute};
        tress_add_rays(rays, &ray, 1);
      }
      return 1;
    };
    const tress_target target{"peaks", nullptr, trace, nullptr, 0};
    tress_service_create(&target, nullptr, &made);
    tress_slice slice;
    tress_slice_init(&slice);
    const adaptive::SliceDescription of = testing::toy_slice(0, side);
    slice.axis_a = of.axis_a.data();
    slice.axis_b = of.axis_b.data();
    slice.count_a = slice.count_b = side;
    std::uint32_t id = 0;
    tress_service_add_slice(made, &slice, &id);
    tress_report report{};
    while (report.rows_converged < side * side) {
      for (std::uint32_t node = 0; node < side * side; ++node) {
        RandomStream random(3, node);
        for (int i = 0; i < 40; ++i) {
          const std::array<float, 3> u{random.next(), 0, 0};
          tress_value value;
          tress_service_sample(made, {id, node / side, node % side}, u.data(), &value);
        }
      }
      tress_service_publish(made, 0, &report);
    }
    return made;
  }();
  return service;
}

void by_look_up(benchmark::State& state) {
  const adaptive::Service& service = learned();
  const float share = service.options().uniform_share_converged;
  for (auto _ : state) {
    for (std::size_t i = 0; i < count; ++i) {
      const adaptive::RowView row = service.look_up(0, queries.nodes[i].a, queries.nodes[i].b);
      const float x = row.sample(queries.u[i][0], share), q = row.proposal_density(x, share);
      benchmark::DoNotOptimize(row.density(x) / q);
    }
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(count));
}
BENCHMARK(by_look_up);

/// range(0): queries a call.
void whole(benchmark::State& state) {
  const adaptive::Service& service = learned();
  const auto batch = static_cast<std::size_t>(state.range(0));
  std::vector<adaptive::NodeValue> values(batch);
  for (auto _ : state) {
    for (std::size_t i = 0; i < count; i += batch)
      sample(service, std::span(queries.nodes).subspan(i, batch), std::span(queries.u).subspan(i, batch), values);
    benchmark::DoNotOptimize(values.data());
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(count));
}
BENCHMARK(whole)->Arg(1)->Arg(256);

void evaluated(benchmark::State& state) {
  const adaptive::Service& service = learned();
  for (auto _ : state) {
    for (std::size_t i = 0; i < count; ++i)
      benchmark::DoNotOptimize(evaluate(service, queries.nodes[i], 6 * queries.u[i][0] - 3).pdf);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(count));
}
BENCHMARK(evaluated);

void mean_of_nodes(benchmark::State& state) {
  const adaptive::Service& service = learned();
  for (auto _ : state) {
    for (std::size_t i = 0; i < count; ++i)
      benchmark::DoNotOptimize(mean(service, 0, queries.u[i][0], queries.u[i][1], 6 * queries.u[i][2] - 3).pdf);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(count));
}
BENCHMARK(mean_of_nodes);

void from_c(benchmark::State& state) {
  const tress_service* service = learned_in_c();
  const auto batch = static_cast<std::size_t>(state.range(0));
  std::vector<tress_value> values(batch);
  for (auto _ : state) {
    for (std::size_t i = 0; i < count; i += batch)
      tress_service_sample_n(service, &queries.c_nodes[i], queries.u[i].data(), batch, values.data());
    benchmark::DoNotOptimize(values.data());
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(count));
}
BENCHMARK(from_c)->Arg(1)->Arg(256);

}  // namespace
}  // namespace tress::bench

BENCHMARK_MAIN();
