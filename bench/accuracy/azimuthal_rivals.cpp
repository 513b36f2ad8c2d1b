// What the azimuthal part of one lobe costs and how far it is from the truth, for every way of having it: Google
// Benchmark, whose counters are the errors.
//
//   TRESS_BENCH_ROWS=256 bench_azimuthal_rivals --benchmark_filter=hard/sketch
//
// Names are DOMAIN/RIVAL/evaluate and .../sample (a sample with its density). Domains, of random rows of TT, TRT and
// TRRT of clear hair: whole, sigma 1..45 degrees, e 0.5..1; hard, sigma 1..10, e 0.7..1. Errors are relative squared
// L2, integral (g - f)^2 / max(integral (g - mean)^2, 1e-3 / 2 pi), of N at the row's own phi_r, theta_d, e and sigma
// against the Fourier reference: quantiles over rows. Rows are read as a render reads them, three channels and the
// density of the proposal in one; times are of brown hair, errors of clear. The error of the grid (a direction is
// answered by a node near it) is in none of them: nodes only.
//
// quadrature N: N midpoint rays through the ellipse, traced for each direction. exact: as many as the program takes.
// deon2011 N: the circle, traced for all lobes at once; /shared is a quarter of four lobes of one trace.
// Refused rows count as they were left, but for those that have no fit at all (of the learner `table`): `rows` of
// all are reported. circle_error_*: against the reference of e = 1 instead. chiang2016 is timed at one offset, h, and
// its error is that of its mean over h. marschner2003 has no width but its caustics', set to sigma; ou2012 has the
// energies of normal incidence; pekelis2015 the nearest row of its grid, and its time has M in it. Rivals without TRRT
// have no such rows.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "azimuthal_models.h"
#include "azimuthal_rows.h"
#include "fiber/cross_section.h"
#include "fiber/ray_batch.h"
#include "knot_rows.h"
#include "learned_rows.h"
#include "models/absorbed_row_pool.h"
#include "models/elliptical/ray_shape.h"
#include "models/elliptical/vertex_trace.h"
#include "random_rows.h"
#include "references/learners/absorbed_knots.h"
#include "references/registry.h"
#include "tress/base/random.h"
namespace tress {
namespace {

using namespace bench;

/// Rows as a render reads them: `make_row` gives each one's fit.
class AbsorbedRows : public RivalFacts {
 public:
  void add(const Row& row, const adaptive::Mixture& fit, double part_count) {
    const auto energy = static_cast<float>(fit.energy());
    const fiber::AbsorbedRow& colorless = *pool_.make(fit, 0, clear);
    errors.push_back(row.own.error(
        [&](double x) {
          return static_cast<double>(energy * colorless.evaluate(static_cast<float>(x), mix, share).shape.g);
        },
        row.sigma));
    made_.push_back({brown_pool_.make(fit, 0, brown), energy});
    parts += part_count;
    ++rows;
  }
  Answer evaluate(std::size_t i, float x) const {
    const fiber::RowValue value = made_[i].row->evaluate(x, mix, share);
    return {value.shape * made_[i].energy, value.proposal, x};
  }
  Answer sample(std::size_t i, float u, float) const { return evaluate(i, made_[i].row->sample(u, mix, share)); }

 private:
  struct Made {
    const fiber::AbsorbedRow* row;
    float energy;
  };
  fiber::AbsorbedRowPool pool_, brown_pool_;
  std::vector<Made> made_;
};

std::unique_ptr<bench::LearnedRows> learn(const Domain& domain, const adaptive::Learner* learner, double epsilon) {
  adaptive::Options options;
  options.epsilon = epsilon;
  options.learner = learner;
  options.memory_bytes = std::size_t{2} << 30;
  options.seed = 1;
  std::vector<adaptive::SliceDescription> slices;
  for (const Row& row : domain.rows) slices.push_back(row.random.description);
  auto learned = std::make_unique<bench::LearnedRows>(options, *domain.target, slices);
  constexpr int passes = 64, vertices = 16;
  for (int pass = 0; pass < passes; ++pass) {
    if (learned->pass(vertices).rows_converged == slices.size()) break;
  }
  return learned;
}

/// As the learner left them: refused rows too, which a render would trace. What never got a fit is left out.
std::unique_ptr<AbsorbedRows> learned_rows(const Domain& domain, const adaptive::Learner* learner, double epsilon) {
  const auto learned = learn(domain, learner, epsilon);
  auto made = std::make_unique<AbsorbedRows>();
  for (std::size_t i = 0; i < domain.rows.size(); ++i) {
    const adaptive::RowView view = learned->view(i);
    if (view.fit != nullptr) made->add(domain.rows[i], *view.fit, view.fit->component_count);
  }
  return made;
}

/// Knot tables as a render would read them.
class KnotRows : public RivalFacts {
 public:
  void add(const Row& row, const adaptive::KnotDensity& table) {
    const fiber::AbsorbedKnots colorless(table, clear);
    errors.push_back(row.own.error(
        [&](double x) {
          return static_cast<double>(table.energy() * colorless.evaluate(static_cast<float>(x), mix, share).shape.g);
        },
        row.sigma));
    made_.push_back({fiber::AbsorbedKnots(table, brown), table.energy()});
    parts += static_cast<double>(table.knots().size());
    ++rows;
  }
  Answer evaluate(std::size_t i, float x) const {
    const fiber::RowValue value = made_[i].row.evaluate(x, mix, share);
    return {value.shape * made_[i].energy, value.proposal, x};
  }
  Answer sample(std::size_t i, float u, float) const { return evaluate(i, made_[i].row.sample(u, mix, share)); }

 private:
  struct Made {
    fiber::AbsorbedKnots row;
    float energy;
  };
  std::vector<Made> made_;
};

/// Of this epsilon; rows above it are left out.
std::unique_ptr<KnotRows> knot_rows_to(const Domain& domain, double epsilon) {
  auto made = std::make_unique<KnotRows>();
  bench::KnotFitter fitter{epsilon};
  for (const Row& row : domain.rows) {
    const bench::KnotRow fitted = fitter.fit(adaptive::TracedNodes(row.random.rays, row.sigma));
    if (fitted.converged) made->add(row, fitted.table);
  }
  return made;
}

std::unique_ptr<KnotRows> knot_rows(const Domain& domain, std::size_t count) {
  auto made = std::make_unique<KnotRows>();
  for (const Row& row : domain.rows) {
    const adaptive::TracedNodes nodes(row.random.rays, row.sigma);
    double epsilon = 1e9;  // four times what it must not be above: 32 knots do
    adaptive::KnotFit fit = adaptive::fit_knots(nodes, epsilon);
    while (fit.table.knots().size() < count && epsilon > 0) {
      epsilon = fit.objective * 3.9;
      fit = adaptive::fit_knots(nodes, epsilon);
    }
    made->add(row, adaptive::with_attributes(fit.table, nodes));
  }
  return made;
}

/// The mixture itself, one channel, as the service has it: the density of its sampler alone.
class OneChannel : public RivalFacts {
 public:
  OneChannel(const Domain& domain, double epsilon) {
    const auto learned = learn(domain, &adaptive::sketch_learner, epsilon);
    for (std::size_t i = 0; i < domain.rows.size(); ++i) {
      const adaptive::RowView view = learned->view(i);
      if (view.fit == nullptr) continue;
      fits_.push_back(*view.fit);
      parts += view.fit->component_count;
      errors.push_back(domain.rows[i].own.error(
          [&](double x) { return static_cast<double>(fits_.back().density(static_cast<float>(x))); },
          domain.rows[i].sigma));
    }
    rows = fits_.size();
  }
  Answer evaluate(std::size_t i, float x) const { return {clear, fits_[i].proposal_density(x, share), x}; }
  Answer sample(std::size_t i, float u, float) const { return evaluate(i, fits_[i].sample(u, share)); }

 private:
  std::vector<adaptive::Mixture> fits_;
};

/// Rays through the ellipse, for each direction anew.
class Quadrature : public RivalFacts {
 public:
  /// rays: 0, as the program takes.
  Quadrature(const Domain& domain, int rays) : domain_(domain), rays_(rays) {
    for (const Row& row : domain.rows) {
      const Traced traced(row, count(row));
      errors.push_back(row.own.error(
          [&](double x) {
            return static_cast<double>(fiber::ray_density(traced.shape(), clear, static_cast<float>(x)).clear);
          },
          row.sigma));
    }
    rows = domain.rows.size();
  }
  Answer evaluate(std::size_t i, float x) const {
    const Row& row = domain_.rows[i];
    return value(Traced(row, count(row)), x);
  }
  Answer sample(std::size_t i, float u, float u_other) const {
    const Row& row = domain_.rows[i];
    const Traced traced(row, count(row));
    return value(traced,
                 fiber::draw_azimuth(traced.shape(), 0, fiber::ray_mass(traced.shape(), clear).clear, u, u_other));
  }

 private:
  struct Traced {
    std::array<float, 4096> azimuth, weight, path;
    std::size_t size = 0;
    float sigma;

    Traced(const Row& row, int rays) : sigma(row.sigma) {
      const fiber::CrossSection section(static_cast<double>(eta), row.e, row.phi_r, row.theta_d);
      const double step = 2.0 / rays;
      for (int first = 0; first < rays; first += fiber::RayBatch::lanes) {
        fiber::RayBatch batch(section, -1 + (first + 0.5) * step, step);
        for (int order = 0; order < row.p; ++order) batch.advance();
        std::array<float, fiber::RayBatch::lanes> at;
        batch.azimuths(at.data());
        for (int lane = 0; lane < std::min(fiber::RayBatch::lanes, rays - first); ++lane) {
          if (!(batch.weight()[lane] > 0)) continue;
          azimuth[size] = adaptive::wrap_angle(at[static_cast<std::size_t>(lane)]);
          weight[size] = static_cast<float>(batch.weight()[lane] / rays);
          path[size++] = static_cast<float>(batch.path()[lane]);
        }
      }
    }
    fiber::RayShape shape() const {
      return {{azimuth.data(), size}, {weight.data(), size}, {path.data(), size}, sigma};
    }
  };
  int count(const Row& row) const { return rays_ > 0 ? rays_ : std::min(4096, fiber::vertex_ray_count(row.sigma)); }
  static Answer value(const Traced& traced, float x) {
    const fiber::ClearAndAbsorbed sum = fiber::ray_density(traced.shape(), brown, x);
    return {sum.absorbed, glm::dot(mix, sum.absorbed), x};
  }

  const Domain& domain_;
  int rays_;
};

struct Input {
  std::size_t row;
  float x, u, u_other;
};

std::vector<Input> inputs(std::size_t rows) {
  RandomStream random(2);
  std::vector<Input> all(4096);
  for (Input& in : all) {
    in.row = static_cast<std::size_t>(random.next() * static_cast<float>(rows)) % rows;
    in.x = static_cast<float>(2 * pi * (static_cast<double>(random.next()) - 0.5));
    in.u = random.next();
    in.u_other = random.next();
  }
  return all;
}

template <class Rival, class Do>
void loop(benchmark::State& state, const Rival& rival, Do once) {
  const std::vector<Input> all = inputs(rival.rows);
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(once(rival, all[i++ % all.size()]));
}

void add_counters(benchmark::State& state, const std::string& prefix, const std::vector<double>& errors) {
  if (errors.empty()) return;
  const nlohmann::json spread = bench::spread(errors);
  for (const auto& [name, value] : spread.items()) state.counters[prefix + name] = value.get<double>();
}

template <class Rival>
std::shared_ptr<Lazy<Rival>> add(const std::string& name, std::function<std::unique_ptr<Rival>()> make) {
  auto rival = std::make_shared<Lazy<Rival>>(std::move(make));
  benchmark::RegisterBenchmark((name + "/evaluate").c_str(), [rival](benchmark::State& state) {
    const Rival& made = rival->get();
    loop(state, made, [](const Rival& r, const Input& in) { return r.evaluate(in.row, in.x); });
    add_counters(state, "error_", made.errors);
    add_counters(state, "circle_error_", made.circle_errors);
    state.counters["rows"] = static_cast<double>(made.errors.size());
    state.counters["parts"] = made.parts / static_cast<double>(made.errors.size());
  });
  benchmark::RegisterBenchmark((name + "/sample").c_str(), [rival](benchmark::State& state) {
    loop(state, rival->get(), [](const Rival& r, const Input& in) { return r.sample(in.row, in.u, in.u_other); });
  });
  return rival;
}

void add_domain(const std::string& name) {
  const auto domain = std::make_shared<Lazy<Domain>>([name] { return std::make_unique<Domain>(name); });
  for (const adaptive::Learner* info : references::learners()) {
    for (const double epsilon : {0.1, 0.03, 0.01, 0.003, 0.001}) {
      add<AbsorbedRows>(fmt::format("{}/{} {}", name, info->name, epsilon),
                        [domain, learner = info, epsilon] { return learned_rows(domain->get(), learner, epsilon); });
    }
  }
  for (const double epsilon : {0.1, 0.03, 0.01, 0.003, 0.001}) {
    add<KnotRows>(fmt::format("{}/table {}", name, epsilon),
                  [domain, epsilon] { return knot_rows_to(domain->get(), epsilon); });
  }
  add<OneChannel>(name + "/one-channel 0.01", [domain] { return std::make_unique<OneChannel>(domain->get(), 0.01); });
  for (const std::size_t knots : {std::size_t{32}, std::size_t{64}, std::size_t{128}}) {
    add<KnotRows>(fmt::format("{}/knots {}", name, knots), [domain, knots] { return knot_rows(domain->get(), knots); });
  }
  for (const int points : {10, 35, 100}) {
    add<Quadrature>(fmt::format("{}/quadrature {}", name, points),
                    [domain, points] { return std::make_unique<Quadrature>(domain->get(), points); });
    const std::string deon = fmt::format("{}/deon2011 {}", name, points);
    const auto rival =
        add<Deon2011>(deon, [domain, points] { return std::make_unique<Deon2011>(domain->get(), points); });
    benchmark::RegisterBenchmark((deon + "/four").c_str(), [rival](benchmark::State& state) {
      loop(state, rival->get(), [](const Deon2011& r, const Input& in) { return r.evaluate_four(in.row, in.x); });
    });
  }
  add<Quadrature>(name + "/exact", [domain] { return std::make_unique<Quadrature>(domain->get(), 0); });
  add<Chiang2016>(name + "/chiang2016", [domain] { return std::make_unique<Chiang2016>(domain->get()); });
  add<Marschner2003>(name + "/marschner2003", [domain] { return std::make_unique<Marschner2003>(domain->get()); });
  add<Deon2022>(name + "/deon2022", [domain] { return std::make_unique<Deon2022>(domain->get()); });
  add<Ou2012>(name + "/ou2012", [domain] { return std::make_unique<Ou2012>(domain->get()); });
  add<Pekelis2015>(name + "/pekelis2015", [domain] { return std::make_unique<Pekelis2015>(domain->get()); });
}

/// What the loops cost by themselves.
struct Nothing : RivalFacts {
  Nothing() { rows = 128, errors = {0}; }
  Answer evaluate(std::size_t i, float x) const { return {glm::vec3(x), static_cast<float>(i), x}; }
  Answer sample(std::size_t i, float u, float u_other) const { return {glm::vec3(u_other), static_cast<float>(i), u}; }
};

}  // namespace
}  // namespace tress

int main(int argc, char** argv) {
  for (const char* domain : {"whole", "hard"}) tress::add_domain(domain);
  tress::add<tress::Nothing>("loop", [] { return std::make_unique<tress::Nothing>(); });
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
