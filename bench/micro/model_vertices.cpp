// What a vertex costs under every model of the registry, all in one run.
//   vertex/NAME: begin, sample with S and Q there, S and Q for one light; sample/NAME: without the light;
//   light/NAME: the light alone, which models that can only be sampled have not;
//   spectrum/NAME/N: the light alone, in N channels of absorptions that no fiber has, of models that have spectra;
//   color/NAME: adding a fiber of another color, which a texture took before;
//   session/NAME/KB: a table from nothing within so much memory, 8 passes of 2,000 vertices, publishing included.
// Known directions all over the sphere, brown hair. Models with rows have learned them before, and are measured once
// more tracing every vertex (`exact`); models that integrate with 10, 35 and 100 points.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "models/learned_model.h"
#include "references/registry.h"
#include "tress/fiber/rough_model.h"

namespace tress {
namespace {

using fiber::FiberDirection;
using fiber::FiberEvent;
using fiber::FiberModel;

const glm::vec3 brown(0.545f, 0.906f, 1.781f);

/// A model with one fiber, however it is kept.
struct Measured {
  std::shared_ptr<const void> owner;
  const FiberModel* model = nullptr;
  fiber::FiberId fiber = 0;
};

std::vector<FiberDirection> known_directions() {
  constexpr int count = 48;
  RandomStream random(1);
  std::vector<FiberDirection> known;
  for (int i = 0; i < count; ++i) {
    known.push_back({std::asin(1.9f * (random.next() - 0.5f)), 6.28f * (random.next() - 0.5f)});
  }
  return known;
}

fiber::FiberParameters brown_fiber() {
  fiber::FiberParameters parameters;
  parameters.sigma_a = brown;
  return parameters;
}

Measured made(const fiber::ModelInfo& info, const fiber::ModelSettings& settings) {
  std::shared_ptr<FiberModel> model = info.make(settings);
  const fiber::FiberId id = model->add_fiber(brown_fiber());
  return {model, model.get(), id};
}

Measured taught(const fiber::ModelInfo& info) {
  auto learned =
      std::make_shared<test::LearnedModel>(brown_fiber(), fiber::Estimator::fitted, adaptive::Options{}, info);
  for (int round = 0; round < 10; ++round) {
    for (const FiberDirection& wr : known_directions()) {
      learned->teach(wr, 1, 1000, static_cast<std::uint64_t>(round), false);
    }
  }
  return {learned, &learned->model(), 0};
}

enum class Part { vertex, sample, light };

std::vector<FiberEvent> events_of(const Measured& measured) {
  RandomStream random(1);
  std::vector<FiberEvent> events;
  for (const FiberDirection& wr : known_directions()) {
    const float xi1 = random.next(), xi2 = random.next();
    events.push_back(measured.model->begin(measured.fiber, wr, xi1, xi2, 0));
  }
  return events;
}

void measure_spectrum(benchmark::State& state, const Measured& measured) {
  const std::vector<FiberEvent> events = events_of(measured);
  RandomStream random(1);
  std::vector<float> sigma_a(static_cast<std::size_t>(state.range(0))), s(sigma_a.size());
  std::size_t next = 0;
  for (auto _ : state) {
    for (float& one : sigma_a) one = 2 * random.next();
    const FiberEvent& event = events[next++ % events.size()];
    if (!measured.model->evaluates(event)) continue;
    const FiberDirection wi{2.5f * (random.next() - 0.5f), 6.28f * (random.next() - 0.5f)};
    benchmark::DoNotOptimize(measured.model->evaluate_spectrum(event, wi, sigma_a, s));
    benchmark::DoNotOptimize(s.data());
  }
}

/// range(0): the memory limit in KB.
void measure_session(benchmark::State& state, const fiber::ModelInfo& info) {
  double answered = 0, made_anew = 0;
  for (auto _ : state) {
    state.PauseTiming();
    adaptive::Options options;
    options.memory_bytes = static_cast<std::size_t>(state.range(0)) * 1000;
    test::LearnedModel learned(brown_fiber(), fiber::Estimator::fitted, options, info);
    state.ResumeTiming();
    learned.service().prepare();
    for (std::uint64_t pass = 0; pass < 8; ++pass) {
      for (std::uint64_t i = 0; i < 2000; ++i) {
        RandomStream random(4, pass, i);
        const FiberDirection wr{std::asin(1.9f * (random.next() - 0.5f)), 6.28f * (random.next() - 0.5f)};
        const FiberEvent event = learned.begin(wr, random.next(), random.next());
        const auto sample = learned.model().sample(event, {random.next(), random.next(), random.next(), random.next()});
        benchmark::DoNotOptimize(sample);
        if (!learned.model().evaluates(event)) continue;
        benchmark::DoNotOptimize(
            learned.model().evaluate(event, {2.5f * (random.next() - 0.5f), 6.28f * (random.next() - 0.5f)}));
      }
      const adaptive::PassReport report = learned.service().publish(2000);
      answered = static_cast<double>(report.answered_queries) / static_cast<double>(report.queries);
      made_anew = static_cast<double>(report.forms_made_anew) / static_cast<double>(report.queries);
    }
  }
  state.counters["answered"] = answered;
  state.counters["made_anew"] = made_anew;
}

void measure_color(benchmark::State& state, FiberModel& model) {
  fiber::FiberParameters parameters = brown_fiber();
  const std::size_t before = model.bytes();
  for (auto _ : state) {
    parameters.sigma_a.x += 1e-3f;
    benchmark::DoNotOptimize(model.add_fiber(parameters));
  }
  state.counters["KB"] = static_cast<double>(model.bytes() - before) / 1000 / static_cast<double>(state.iterations());
}

void measure(benchmark::State& state, const Measured& measured, Part part) {
  const std::vector<FiberDirection> known = known_directions();
  const FiberModel& model = *measured.model;
  RandomStream random(1);
  const auto begin = [&](const FiberDirection& wr) {
    const float xi1 = random.next(), xi2 = random.next(), h = 2 * random.next() - 1;
    return model.begin(measured.fiber, wr, xi1, xi2, h);
  };
  std::vector<FiberEvent> events;
  for (const FiberDirection& wr : known) events.push_back(begin(wr));
  std::size_t next = 0;
  double queries = 0, exact = 0;
  const auto count = [&](const fiber::FiberValue& value) {
    queries += value.queries;
    exact += value.exact_queries;
  };
  for (auto _ : state) {
    const std::size_t i = next++ % known.size();
    const FiberEvent event = part == Part::light ? events[i] : begin(known[i]);
    if (part != Part::light) {
      const auto sample = model.sample(event, {random.next(), random.next(), random.next(), random.next()});
      benchmark::DoNotOptimize(sample);
      count(sample.value);
    }
    if (part != Part::sample && model.evaluates(event)) {
      const auto light = model.evaluate(event, {2.5f * (random.next() - 0.5f), 6.28f * (random.next() - 0.5f)});
      benchmark::DoNotOptimize(light);
      count(light);
    }
  }
  if (queries > 0) state.counters["exact_share"] = exact / queries;
}

/// Made when first measured: a filter spares the others' teaching.
void add(const std::string& name, bool has_light, bool has_spectra, const std::function<Measured()>& make) {
  const auto shared = std::make_shared<Measured>();
  const auto add_part = [&](const char* prefix, Part part) {
    benchmark::RegisterBenchmark((prefix + name).c_str(), [shared, make, part](benchmark::State& state) {
      if (shared->model == nullptr) *shared = make();
      measure(state, *shared, part);
    });
  };
  if (has_spectra) {
    benchmark::RegisterBenchmark(("spectrum/" + name).c_str(),
                                 [shared, make](benchmark::State& state) {
                                   if (shared->model == nullptr) *shared = make();
                                   measure_spectrum(state, *shared);
                                 })
        ->Arg(1)
        ->Arg(3)
        ->Arg(4)
        ->Arg(8);
    benchmark::RegisterBenchmark(("color/" + name).c_str(), [](benchmark::State& state) {
      measure_color(state, **fiber::make_rough_model(fiber::Estimator::exact, nullptr));
    })->Iterations(20);
  }
  add_part("vertex/", Part::vertex);
  add_part("sample/", Part::sample);
  if (has_light) add_part("light/", Part::light);
}

}  // namespace
}  // namespace tress

int main(int argc, char** argv) {
  using namespace tress;
  for (const fiber::ModelInfo& info : references::models()) {
    const std::string name = info.name;
    if (info.has_rows()) {
      add(name + "/learned", true, info.learns_samples(), [&info] { return taught(info); });
      if (name == "rough" || name == "elliptical") {
        benchmark::RegisterBenchmark(("session/" + name).c_str(),
                                     [&info](benchmark::State& state) { measure_session(state, info); })
            ->ArgsProduct({{0, 30, 100, 300, 1000, 3000, 10000, 100000}})
            ->Iterations(1)
            ->MeasureProcessCPUTime()
            ->Unit(benchmark::kMillisecond);
      }
      const bool traces = info.learns_samples();  // a path at every vertex, which no light can be credited for
      add(name + "/exact", !traces, false, [&info] { return made(info, {.estimator = fiber::Estimator::exact}); });
    } else if (info.has_quadrature) {
      for (const int points : {10, 35, 100}) {
        add(name + "/" + std::to_string(points), true, false,
            [&info, points] { return made(info, {.quadrature_points = points}); });
      }
    } else {
      add(name, info.make({})->evaluates(), false, [&info] { return made(info, {}); });
    }
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
