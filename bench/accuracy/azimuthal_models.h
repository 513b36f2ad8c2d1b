// Other models' azimuthal parts, as bench_azimuthal_rivals compares them (its head says what is compared).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "azimuthal_rows.h"
#include "base/normal_quantile.h"
#include "fiber/circle_ray.h"
#include "fiber/cross_section.h"
#include "fiber/longitudinal.h"
#include "models/elliptical/ray_shape.h"
#include "references/models/deon2011_azimuth.h"
#include "references/models/deon2022.h"
#include "references/models/marschner_table.h"
#include "references/models/ou2012_lobes.h"
#include "references/registry.h"
#include "tress/adaptive/service.h"
#include "tress/base/random.h"

namespace tress::bench {

class Deon2011 : public RivalFacts {
 public:
  Deon2011(const Domain& domain, int points) : domain_(domain), quadrature_(points) {
    for (const Row& row : domain.rows) {
      fibers_.push_back({eta, brown * fiber::circle_radius(row.e), splat(row.sigma)});
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
    return value(i, adaptive::wrap_angle(trace_.sample(domain_.rows[i].p, mix, u, normal_quantile(u_other))));
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
class Chiang2016 : public RivalFacts {
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
      const float e = exp_of_negative(-std::abs(adaptive::wrap_angle(x - mu)) * inverse_s);
      return e * inverse_s / (mass * (1 + e) * (1 + e));
    }
  };
  static Answer value(const Lobe& lobe, float x) {
    const float density = lobe.density(x);
    return {lobe.energy * density, density, x};
  }
  std::vector<Fiber> fibers_;
};

class Marschner2003 : public RivalFacts {
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

/// TT, which is not blurred, and TRT, of the roughness whose TRT has the row's sigma.
class Deon2022 : public RivalFacts {
 public:
  explicit Deon2022(const Domain& domain) {
    for (const Row& row : domain.rows) {
      if (row.p > 2) continue;
      const float roughness = row.sigma / 1.8f;  // azimuthal_sigmas()
      fibers_.push_back({row.p, roughness, row.theta_d, {eta, roughness, row.theta_d}});
      const auto curve = [&](double x) {
        return static_cast<double>(density(fibers_.back(), clear, static_cast<float>(x)).g);
      };
      errors.push_back(row.own.error(curve, row.sigma));
      circle_errors.push_back(row.circle.error(curve, row.sigma));
    }
    rows = fibers_.size();
  }
  Answer evaluate(std::size_t i, float x) const {
    const Fiber& fiber = fibers_[i];
    return {density(fiber, brown, x), fiber.draws.density(fiber.p, x), x};
  }
  Answer sample(std::size_t i, float u, float u_other) const {
    return evaluate(i, fibers_[i].draws.sample(fibers_[i].p, u, u_other));
  }

 private:
  struct Fiber {
    int p;
    float roughness, theta_d;
    fiber::Deon2022Draws draws;
  };
  static glm::vec3 density(const Fiber& fiber, const glm::vec3& sigma_a, float x) {
    return fiber::deon2022_azimuthal(fiber.p, eta, fiber.roughness, sigma_a, fiber.theta_d, x);
  }
  std::vector<Fiber> fibers_;
};

class Ou2012 : public RivalFacts {
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
class Pekelis2015 : public RivalFacts {
 public:
  explicit Pekelis2015(const Domain& domain) {
    constexpr std::size_t most = 48;  // each is taught by itself
    model_ = references::find_model("pekelis2015")->make({.service = learned_.service.get()});
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
      (void)learned_.service->publish();
    }
  }

  fiber::ModelService learned_ = fiber::make_service(*references::find_model("pekelis2015"), adaptive::Options{});
  std::unique_ptr<fiber::FiberModel> model_;
  std::vector<Event> events_;
};

}  // namespace tress::bench
