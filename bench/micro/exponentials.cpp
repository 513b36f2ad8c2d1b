// exp of a vector of doubles: ours of src/base/exp_lanes.h beside Highway's, on 1,024 values in [-31, 0].
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstddef>
#include <vector>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "micro/exponentials.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "base/exp_lanes.h"
#include "hwy/contrib/math/math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tress::bench {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using tress::HWY_NAMESPACE::Doubles;

void Ours(const double* in, double* out, std::size_t n) {
  const Doubles d;
  for (std::size_t i = 0; i < n; i += hn::Lanes(d))
    hn::StoreU(tress::HWY_NAMESPACE::Exp(hn::LoadU(d, in + i)), d, out + i);
}

void Highways(const double* in, double* out, std::size_t n) {
  const Doubles d;
  for (std::size_t i = 0; i < n; i += hn::Lanes(d)) hn::StoreU(hn::Exp(d, hn::LoadU(d, in + i)), d, out + i);
}

}  // namespace HWY_NAMESPACE
}  // namespace tress::bench
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tress::bench {
namespace {

HWY_EXPORT(Ours);
HWY_EXPORT(Highways);

/// Time a call of 1,024 values; the counter is the largest relative error against std::exp.
void run(benchmark::State& state, void (*exponentials)(const double*, double*, std::size_t)) {
  std::vector<double> in(1024), out(in.size());
  for (std::size_t i = 0; i < in.size(); ++i) in[i] = -0.03 * static_cast<double>(i);
  for (auto _ : state) {
    exponentials(in.data(), out.data(), in.size());
    benchmark::DoNotOptimize(out.data());
    benchmark::ClobberMemory();
  }
  double error = 0;
  for (std::size_t i = 0; i < in.size(); ++i) error = std::fmax(error, std::fabs(out[i] / std::exp(in[i]) - 1));
  state.counters["relative_error"] = error;
}

void ours(benchmark::State& state) {
  run(state, [](const double* in, double* out, std::size_t n) { HWY_DYNAMIC_DISPATCH(Ours)(in, out, n); });
}
void highways(benchmark::State& state) {
  run(state, [](const double* in, double* out, std::size_t n) { HWY_DYNAMIC_DISPATCH(Highways)(in, out, n); });
}
BENCHMARK(ours);
BENCHMARK(highways);

}  // namespace
}  // namespace tress::bench

BENCHMARK_MAIN();
#endif
