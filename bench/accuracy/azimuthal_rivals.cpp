// What the azimuthal part of one lobe costs and how far it is from the truth, for every way of having it: Google
// Benchmark, whose counters are the errors.
//
//   TRESS_BENCH_ROWS=256 bench_azimuthal_rivals --benchmark_filter=hard/sketch
//
// Names are DOMAIN/RIVAL/evaluate and .../sample (a sample with its density). Domains, of random rows of TT, TRT and
// TRRT of clear hair: whole, sigma 1..45 degrees, e .5..1; hard, sigma 1..10, e .7..1. Errors are relative squared L2,
// integral (g - f)^2 / max(integral (g - mean)^2, 1e-3 / 2 pi), of
// N at the row's own phi_r, theta_d, e and sigma against the Fourier reference: quantiles over rows. Rows are read as a
// render reads them, three channels and the density of the proposal in one; times are of brown hair, errors of clear.
// The error of the grid (a direction is answered by a node near it) is in none of them: nodes only.
//
// quadrature N: N midpoint rays through the ellipse, traced for each direction. exact: as many as the program takes.
// deon2011 N: the circle, traced for all lobes at once; /shared is a quarter of four lobes of one trace.
// Refused rows count as they were left, but for those that have no fit at all (of the learner `table`): `rows` of
// all are told. circle_error_*: against the reference of e = 1 instead. chiang2016 is timed at one offset, h, and its
// error is that of its mean over h. marschner2003 has no width but its caustics', set to sigma; ou2012 has the energies
// of normal incidence; pekelis2015 the nearest row of its grid, and its time has M in it. Rivals without TRRT have no
// such rows.
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

#include "fiber/circle_ray.h"
#include "fiber/cross_section.h"
#include "fiber/fourier_reference.h"
#include "fiber/longitudinal.h"
#include "fiber/ray_batch.h"
#include "knots/fit_knots.h"
#include "learned_rows.h"
#include "models/deon2011_azimuth.h"
#include "models/elliptical/ray_shape.h"
#include "models/elliptical/tinted_row.h"
#include "models/elliptical/vertex_trace.h"
#include "models/marschner_table.h"
#include "models/ou2012_lobes.h"
#include "models/registry.h"
#include "random_rows.h"
#include "tress/adaptive/random.h"

namespace tress {
namespace {

constexpr double pi = std::numbers::pi;
constexpr float share = 0.02f;  ///< of the proposal, uniform
constexpr float eta = 1.55f;
const glm::vec3 brown(0.545f, 0.906f, 1.781f), mix(0.5f, 0.3f, 0.2f), clear(0.0f);

/// Made when it is first asked for.
template <class T>
class Lazy {
 public:
  explicit Lazy(std::function<std::unique_ptr<T>()> make) : make_(std::move(make)) {}
  const T& get() {
    if (!made_) made_ = make_();
    return *made_;
  }

 private:
  std::function<std::unique_ptr<T>()> make_;
  std::unique_ptr<T> made_;
};

/// Equal steps of the circle, fine enough for squares of a blur.
std::vector<double> azimuths(double sigma) {
  const auto n = static_cast<int>(std::max(360.0, std::ceil(8 * pi / sigma)));
  std::vector<double> x;
  for (int i = 0; i < n; ++i) x.push_back(-pi + 2 * pi * i / n);
  return x;
}

struct Reference {
  std::vector<double> density;
  double variation = 0;

  /// eccentricity: of the fiber that is the truth.
  Reference(int p, double e, double phi_r, double theta_d, double sigma) {
    const fiber::FourierReference truth({.eta = static_cast<double>(eta),
                                         .eccentricity = e,
                                         .theta_d = theta_d,
                                         .phi_r = phi_r,
                                         .sigma = sigma,
                                         .p = p,
                                         .nodes = 8192});
    const double mean = truth.energy() / (2 * pi);
    for (const double x : azimuths(sigma)) {
      density.push_back(truth.density(phi_r + x));
      variation += (density.back() - mean) * (density.back() - mean);
    }
    variation = std::max(variation * 2 * pi / static_cast<double>(density.size()), 1e-3 / (2 * pi));
  }
  template <class Curve>
  double error(const Curve& curve, double sigma) const {
    double sum = 0;
    std::size_t i = 0;
    for (const double x : azimuths(sigma)) {
      const double off = density[i++] - curve(x);
      sum += off * off;
    }
    return sum * 2 * pi / static_cast<double>(density.size()) / variation;
  }
};

struct Row {
  bench::RandomRows::Row random;
  int p = 1;
  float e = 1, sigma = 1, phi_r = 0, theta_d = 0;
  Reference own, circle;

  explicit Row(bench::RandomRows::Row row)
      : random(std::move(row)),
        p(fiber::page_order(static_cast<int>(random.description.key.lobe))),
        e(random.description.key.parameters[1]),
        sigma(random.description.key.parameters[2]),
        phi_r(random.description.axis_a[0]),
        theta_d(random.description.axis_b[0]),
        own(p, e, phi_r, theta_d, sigma),
        circle(p, 1, 0, theta_d, sigma) {}
};

struct Domain {
  std::vector<Row> rows;
  std::unique_ptr<adaptive::Target> target = fiber::make_elliptical_target();

  explicit Domain(const std::string& name) {
    const char* asked = std::getenv("TRESS_BENCH_ROWS");
    const int count = std::max(1, asked ? std::atoi(asked) : 128);
    bench::RandomRows random(1, name == "hard" ? "narrow" : name, false);
    for (int i = 0; i < count; ++i) rows.emplace_back(random.next(*target));
  }
};

struct Answer {
  glm::vec3 density{0.0f};
  float pdf = 0, x = 0;
};

/// What all rivals tell beside their times.
struct Told {
  std::vector<double> errors, circle_errors;  ///< of the rows that it has
  double parts = 0;                           ///< components or knots, mean
  std::size_t rows = 0;
};

/// Rows as a render reads them: `make_row` gives each one's fit.
class TintedRows : public Told {
 public:
  template <class Fit>
  void add(const Row& row, const Fit& fit, double part_count) {
    const auto energy = static_cast<float>(fit.energy());
    const fiber::TintedRow& colorless = *pool_.make(fit, 0, clear);
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
    const fiber::TintedRow* row;
    float energy;
  };
  fiber::TintedRowPool pool_, brown_pool_;
  std::vector<Made> made_;
};

std::unique_ptr<bench::LearnedRows> learn(const Domain& domain, adaptive::Learner learner, double epsilon) {
  adaptive::Options options;
  options.epsilon = epsilon;
  options.learner = learner;
  options.memory_bytes = std::size_t{2} << 30;
  options.seed = 1;
  std::vector<adaptive::PageDescription> pages;
  for (const Row& row : domain.rows) pages.push_back(row.random.description);
  auto learned = std::make_unique<bench::LearnedRows>(options, *domain.target, pages);
  constexpr int passes = 64, vertices = 16;
  for (int pass = 0; pass < passes; ++pass) {
    if (learned->pass(vertices).rows_converged == pages.size()) break;
  }
  return learned;
}

/// As the learner left them: refused rows too, which a render would trace. What never got a fit is left out.
std::unique_ptr<TintedRows> learned_rows(const Domain& domain, adaptive::Learner learner, double epsilon) {
  const auto learned = learn(domain, learner, epsilon);
  auto made = std::make_unique<TintedRows>();
  for (std::size_t i = 0; i < domain.rows.size(); ++i) {
    const adaptive::RowView view = learned->view(i);
    if (view.knots != nullptr)
      made->add(domain.rows[i], *view.knots, static_cast<double>(view.knots->knots().size()));
    else if (view.fit != nullptr)
      made->add(domain.rows[i], *view.fit, view.fit->component_count);
  }
  return made;
}

std::unique_ptr<TintedRows> knot_rows(const Domain& domain, std::size_t count) {
  auto made = std::make_unique<TintedRows>();
  for (const Row& row : domain.rows) {
    const adaptive::TracedNodes nodes(row.random.rays, row.sigma);
    double epsilon = 1e9;  // four times what it must not be above: 32 knots do
    adaptive::KnotFit fit = adaptive::fit_knots(nodes, epsilon);
    while (fit.table.knots().size() < count && epsilon > 0) {
      epsilon = fit.objective * 3.9;
      fit = adaptive::fit_knots(nodes, epsilon);
    }
    made->add(row, adaptive::with_attributes(fit.table, nodes), static_cast<double>(fit.table.knots().size()));
  }
  return made;
}

/// The mixture itself, one channel, as the service has it: the density of its sampler alone.
class OneChannel : public Told {
 public:
  OneChannel(const Domain& domain, double epsilon) {
    const auto learned = learn(domain, adaptive::Learner::sketch, epsilon);
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
class Quadrature : public Told {
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
    const fiber::ClearAndTinted sum = fiber::ray_density(traced.shape(), brown, x);
    return {sum.tinted, glm::dot(mix, sum.tinted), x};
  }

  const Domain& domain_;
  int rays_;
};

class Deon2011 : public Told {
 public:
  Deon2011(const Domain& domain, int points) : domain_(domain), quadrature_(points) {
    for (const Row& row : domain.rows) {
      fibers_.push_back({eta, brown * fiber::circle_radius(row.e), fiber::splat(row.sigma)});
      fiber::CircularFiber colorless = fibers_.back();
      colorless.sigma_a = clear;
      fiber::AzimuthalTrace trace;
      trace.trace(quadrature_, colorless, row.theta_d);
      const float energy = trace.mass(row.p).g;
      const auto curve = [&](double x) {
        return static_cast<double>(energy * trace.shape(row.p, static_cast<float>(x)).g);
      };
      errors.push_back(row.own.error(curve, row.sigma));
      circle_errors.push_back(row.circle.error(curve, row.sigma));
    }
    rows = domain.rows.size();
  }
  Answer evaluate(std::size_t i, float x) const {
    trace_.trace(quadrature_, fibers_[i], domain_.rows[i].theta_d);
    return value(i, x);
  }
  Answer sample(std::size_t i, float u, float u_other) const {
    trace_.trace(quadrature_, fibers_[i], domain_.rows[i].theta_d);
    return value(i, adaptive::wrap_angle(trace_.sample(domain_.rows[i].p, mix, u, fiber::normal_quantile(u_other))));
  }
  /// All four lobes of one trace.
  Answer evaluate_four(std::size_t i, float x) const {
    trace_.trace(quadrature_, fibers_[i], domain_.rows[i].theta_d);
    Answer sum;
    for (int p = 0; p < fiber::detected_orders; ++p) sum.density += trace_.shape(p, x);
    sum.pdf = glm::dot(mix, sum.density);
    return sum;
  }

 private:
  Answer value(std::size_t i, float x) const {
    const glm::vec3 shape = trace_.shape(domain_.rows[i].p, x);
    return {shape * trace_.mass(domain_.rows[i].p), glm::dot(mix, shape), x};
  }
  const Domain& domain_;
  fiber::OffsetQuadrature quadrature_;
  std::vector<fiber::CircularFiber> fibers_;
  mutable fiber::AzimuthalTrace trace_;
};

/// TT and TRT: all later orders have no azimuth in it.
class Chiang2016 : public Told {
 public:
  explicit Chiang2016(const Domain& domain) {
    constexpr int offsets = 512;
    for (const Row& row : domain.rows) {
      if (row.p > 2) continue;
      Fiber fiber{row.p, row.theta_d, row.sigma * std::numbers::sqrt3_v<float> / static_cast<float>(pi)};
      const auto x = azimuths(row.sigma);
      std::vector<double> mean(x.size());
      for (int k = 0; k < offsets; ++k) {
        const fiber::CircleRay ray(eta, row.theta_d, 2 * (static_cast<float>(k) + 0.5f) / offsets - 1);
        const Lobe lobe(fiber, ray, clear);
        for (std::size_t i = 0; i < x.size(); ++i)
          mean[i] += static_cast<double>(lobe.energy.g * lobe.density(static_cast<float>(x[i]))) / offsets;
      }
      const auto curve = [&, i = std::size_t{0}](double) mutable { return mean[i++ % mean.size()]; };
      auto first = curve, second = curve;
      errors.push_back(row.own.error([&](double at) { return first(at); }, row.sigma));
      circle_errors.push_back(row.circle.error([&](double at) { return second(at); }, row.sigma));
      fibers_.push_back(fiber);
    }
    rows = fibers_.size();
  }
  Answer evaluate(std::size_t i, float x) const {
    return value(Lobe(fibers_[i], fiber::CircleRay(eta, fibers_[i].theta_d, 0.3f), brown), x);
  }
  Answer sample(std::size_t i, float u, float) const {
    const Lobe lobe(fibers_[i], fiber::CircleRay(eta, fibers_[i].theta_d, 0.3f), brown);
    const float v = std::clamp((2 * u - 1) * lobe.mass, -0.99999994f, 0.99999994f);
    return value(lobe, adaptive::wrap_angle(lobe.mu + 2 * std::atanh(v) / lobe.inverse_s));
  }

 private:
  struct Fiber {
    int p;
    float theta_d, s;
  };
  /// A logistic about the exit, trimmed to the circle.
  struct Lobe {
    float mu, inverse_s, mass;
    glm::vec3 energy;

    Lobe(const Fiber& fiber, const fiber::CircleRay& ray, const glm::vec3& sigma_a)
        : mu(ray.exit_azimuth(fiber.p)),
          inverse_s(1 / fiber.s),
          mass(std::tanh(static_cast<float>(pi) / (2 * fiber.s))) {
      const float f = ray.reflectance;
      const glm::vec3 once = ray.transmittance(sigma_a);
      energy = (1 - f) * (1 - f) * once * (fiber.p > 1 ? f * once : glm::vec3(1.0f));
    }
    float density(float x) const {
      const float e = adaptive::exp_of_negative(-std::abs(adaptive::wrap_angle(x - mu)) * inverse_s);
      return e * inverse_s / (mass * (1 + e) * (1 + e));
    }
  };
  static Answer value(const Lobe& lobe, float x) {
    const float density = lobe.density(x);
    return {lobe.energy * density, density, x};
  }
  std::vector<Fiber> fibers_;
};

class Marschner2003 : public Told {
 public:
  explicit Marschner2003(const Domain& domain) {
    constexpr std::size_t timed = 8;  // their tables are large
    for (const Row& row : domain.rows) {
      if (row.p > 2) continue;
      Fiber fiber{row.p, row.phi_r, row.theta_d, {static_cast<double>(eta), row.e, {}}, nullptr};
      fiber.shape.caustics.width = row.sigma;
      const auto curve = [&](double x) { return static_cast<double>(density(fiber, static_cast<float>(x), clear).g); };
      errors.push_back(row.own.error(curve, row.sigma));
      circle_errors.push_back(row.circle.error(curve, row.sigma));
      if (fibers_.size() == timed) continue;
      fiber.table = std::make_unique<fiber::MarschnerTable>(fiber.shape);
      fibers_.push_back(std::move(fiber));
    }
    rows = fibers_.size();
  }
  Answer evaluate(std::size_t i, float x) const {
    const Fiber& fiber = fibers_[i];
    float pdf = 0;
    for_lobes(fiber, [&](fiber::MarschnerLobe lobe, float part) {
      pdf += part * fiber.table->density(lobe, fiber.table->place(lobe, fiber.phi_r, fiber.theta_d), x);
    });
    return {density(fiber, x, brown), pdf, x};
  }
  Answer sample(std::size_t i, float u, float u_other) const {
    const Fiber& fiber = fibers_[i];
    const auto lobe = fiber.p == 1     ? fiber::MarschnerLobe::tt
                      : u_other < 0.5f ? fiber::MarschnerLobe::trt
                                       : fiber::MarschnerLobe::glint;
    return evaluate(i, fiber.table->sample(lobe, fiber.table->place(lobe, fiber.phi_r, fiber.theta_d), u_other, u));
  }

 private:
  struct Fiber {
    int p;
    float phi_r, theta_d;
    fiber::MarschnerShape shape;
    std::unique_ptr<fiber::MarschnerTable> table;
  };
  template <class Visit>
  static void for_lobes(const Fiber& fiber, Visit visit) {
    if (fiber.p == 1) return visit(fiber::MarschnerLobe::tt, 1.0f);
    visit(fiber::MarschnerLobe::trt, 0.5f);
    visit(fiber::MarschnerLobe::glint, 0.5f);
  }
  static glm::vec3 density(const Fiber& fiber, float x, const glm::vec3& sigma_a) {
    glm::vec3 sum(0.0f);
    for_lobes(fiber, [&](fiber::MarschnerLobe lobe, float) {
      sum +=
          fiber::marschner_density(fiber::marschner_paths(fiber.shape, lobe, fiber.phi_r, fiber.theta_d, x), sigma_a);
    });
    return sum;
  }
  std::vector<Fiber> fibers_;
};

class Ou2012 : public Told {
 public:
  explicit Ou2012(const Domain& domain) {
    for (const Row& row : domain.rows) {
      if (row.p > 2) continue;
      const fiber::CircleFarField far(eta, clear, row.sigma);
      const bool tt = row.p == 1;
      const fiber::AzimuthalBump bump(tt ? static_cast<float>(pi) : far.caustic,
                                      tt ? std::hypot(far.deviation_tt, row.sigma) : row.sigma);
      fibers_.push_back({tt, bump, tt ? glm::vec3(0.0f) : far.trt / 4.0f, (tt ? far.tt : far.glint) / bump.mass()});
      const auto curve = [&](double x) {
        return static_cast<double>(density(fibers_.back(), static_cast<float>(x)).g);
      };
      errors.push_back(row.own.error(curve, row.sigma));
      circle_errors.push_back(row.circle.error(curve, row.sigma));
    }
    rows = fibers_.size();
  }
  Answer evaluate(std::size_t i, float x) const {
    const Fiber& fiber = fibers_[i];
    const float bump = fiber.bump.pdf(x);
    return {density(fiber, x), fiber.tt ? bump : 0.5f * bump + 0.125f * half_cosine(x), x};
  }
  Answer sample(std::size_t i, float u, float u_other) const {
    const Fiber& fiber = fibers_[i];
    const bool broad = !fiber.tt && u_other < 0.5f;
    return evaluate(i, broad ? 2 * std::asin(std::clamp(2 * u - 1, -1.0f, 1.0f)) : fiber.bump.sample(u));
  }

 private:
  struct Fiber {
    bool tt;
    fiber::AzimuthalBump bump;
    glm::vec3 broad, narrow;
  };
  static float half_cosine(float x) { return std::max(std::cos(0.5f * x), 0.0f); }
  static glm::vec3 density(const Fiber& fiber, float x) {
    glm::vec3 sum = fiber.narrow * fiber.bump.height(x);
    if (!fiber.tt) sum += fiber.broad * half_cosine(x);
    return sum;
  }
  std::vector<Fiber> fibers_;
};

/// Through its model, all other lobes without gain, on the specular cone of a narrow M.
class Pekelis2015 : public Told {
 public:
  explicit Pekelis2015(const Domain& domain) : service_(adaptive::Options{}, *target_) {
    constexpr std::size_t most = 48;  // each is taught by itself
    model_ = fiber::find_model("pekelis2015")->make({.service = &service_});
    for (const Row& row : domain.rows) {
      if (row.p > 2 || events_.size() == most) continue;
      events_.push_back(add(row));
    }
    teach();
    std::size_t k = 0;
    for (const Row& row : domain.rows) {
      if (row.p > 2 || k == events_.size()) continue;
      const Event& event = events_[k++];
      const fiber::FiberEvent colorless = begin(event.clear, row);
      const float m = fiber::LongitudinalLobe(row.theta_d, 0, lambda).density(-row.theta_d);
      const auto curve = [&](double x) {
        const auto at = adaptive::wrap_angle(row.phi_r + static_cast<float>(x));
        return static_cast<double>(model_->evaluate(colorless, {-row.theta_d, at}).total().g / m);
      };
      errors.push_back(row.own.error(curve, row.sigma));
      circle_errors.push_back(row.circle.error(curve, row.sigma));
    }
    rows = events_.size();
  }
  Answer evaluate(std::size_t i, float x) const {
    const fiber::FiberEvent& event = events_[i].event;
    const fiber::FiberValue value = model_->evaluate(event, {-event.wr.theta, x});
    return {value.total(), value.pdf, x};
  }
  Answer sample(std::size_t i, float u, float u_other) const {
    const fiber::FiberSample drawn = model_->sample(events_[i].event, {u_other, 0.5f, u, u_other});
    return {drawn.value.total(), drawn.value.pdf, drawn.wi.phi};
  }

 private:
  static constexpr float lambda = static_cast<float>(0.25 * pi / 180);
  struct Event {
    fiber::FiberId clear, brown;
    fiber::FiberEvent event;
  };
  fiber::FiberEvent begin(fiber::FiberId id, const Row& row) const {
    return model_->begin(id, {row.theta_d, row.phi_r}, 0.5f, 0.5f, 0);
  }
  Event add(const Row& row) {
    fiber::FiberParameters parameters;
    parameters.eccentricity = row.e;
    parameters.tilt = 0;
    parameters.azimuthal_sigma.fill(row.sigma);
    parameters.longitudinal_lambda.fill(lambda);
    parameters.gain.fill(clear);
    parameters.gain[static_cast<std::size_t>(row.p)] = glm::vec3(1.0f);
    if (row.p == 2) parameters.gain[static_cast<std::size_t>(fiber::Lobe::glint)] = glm::vec3(1.0f);
    Event event;
    parameters.sigma_a = clear;
    event.clear = model_->add_fiber(parameters);
    parameters.sigma_a = brown;
    event.brown = model_->add_fiber(parameters);
    event.event = begin(event.brown, row);
    return event;
  }
  void teach() {
    RandomStream random(3);
    for (int pass = 0; pass < 24; ++pass) {
      for (const Event& event : events_) {
        for (int i = 0; i < 32; ++i)
          (void)model_->sample(event.event, {random.next(), random.next(), random.next(), random.next()});
      }
      (void)service_.publish();
      model_->rows_changed();
    }
  }

  std::unique_ptr<adaptive::Target> target_ = fiber::find_model("pekelis2015")->make_target();
  adaptive::Service service_;
  std::unique_ptr<fiber::FiberModel> model_;
  std::vector<Event> events_;
};

// ---- the loops --------------------------------------------------------------------------------------------------

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

void tell(benchmark::State& state, const std::string& prefix, const std::vector<double>& errors) {
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
    tell(state, "error_", made.errors);
    tell(state, "circle_error_", made.circle_errors);
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
  for (const adaptive::LearnerInfo& info : adaptive::learners()) {
    for (const double epsilon : {0.1, 0.03, 0.01, 0.003, 0.001}) {
      add<TintedRows>(fmt::format("{}/{} {}", name, info.name, epsilon), [domain, learner = info.learner, epsilon] {
        return learned_rows(domain->get(), learner, epsilon);
      });
    }
  }
  add<OneChannel>(name + "/one-channel 0.01", [domain] { return std::make_unique<OneChannel>(domain->get(), 0.01); });
  for (const std::size_t knots : {std::size_t{32}, std::size_t{64}, std::size_t{128}}) {
    add<TintedRows>(fmt::format("{}/knots {}", name, knots),
                    [domain, knots] { return knot_rows(domain->get(), knots); });
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
  add<Ou2012>(name + "/ou2012", [domain] { return std::make_unique<Ou2012>(domain->get()); });
  add<Pekelis2015>(name + "/pekelis2015", [domain] { return std::make_unique<Pekelis2015>(domain->get()); });
}

/// What the loops cost by themselves.
struct Nothing : Told {
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
