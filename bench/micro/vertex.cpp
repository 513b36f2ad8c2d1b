// What the BCSDF of one vertex costs: begin, sample (with S and Q there) and one evaluation for a light.
#include <benchmark/benchmark.h>

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

const glm::vec3 clear(0.0f), brown(0.545f, 0.906f, 1.781f);
BENCHMARK_CAPTURE(vertex, converged_brown, Rows::converged, brown);
BENCHMARK_CAPTURE(vertex, converged_clear, Rows::converged, clear);
BENCHMARK_CAPTURE(vertex, open_brown, Rows::open, brown);
BENCHMARK_CAPTURE(vertex, unborn_brown, Rows::unborn, brown);
BENCHMARK_CAPTURE(vertex, exact_brown, Rows::traced_at_vertex, brown);

}  // namespace
}  // namespace tress

BENCHMARK_MAIN();
