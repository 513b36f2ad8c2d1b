// What is measured of any model of the registry, by tests and benches alike: masses, weights, chi-square.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <numbers>
#include <vector>

#include "base/color.h"
#include "fiber/energy_table.h"
#include "fiber/longitudinal.h"
#include "models/registry.h"
#include "support/chi_square.h"
#include "support/quadrature.h"
#include "tress/base/random.h"

namespace tress::test {

/// One fiber of one model. A model with rows is traced at the vertex (`exact`), without a service; one that learns from
/// samples, and could only be sampled there, has learned the row of each event of begin(wr, h) instead: until it passes
/// its test at sampled_epsilon.
class OneFiber {
 public:
  OneFiber(const fiber::ModelInfo& info, const fiber::FiberParameters& parameters,
           double sampled_epsilon = adaptive::Options{}.sampled_epsilon) {
    if (info.learns_samples()) {
      learned_ = fiber::make_service(info, adaptive::Options{.sampled_epsilon = sampled_epsilon,
                                                             .learns_to_epsilon = true,
                                                             .queries_before_creation = 1,
                                                             .heard_share = 0});
      model_ = info.make({.service = learned_.service.get()});
    } else {
      model_ = info.make({.estimator = fiber::Estimator::exact, .service = nullptr});
    }
    id_ = model_->add_fiber(parameters);
  }

  const fiber::FiberModel& model() const { return *model_; }
  fiber::FiberEvent begin(const fiber::FiberDirection& wr, float h = 0.3f) const {
    const auto event = [&] { return model_->begin(id_, wr, 0.37f, 0.61f, h); };
    (void)event();
    if (learned_.service) (void)learned_.service->publish();
    return event();
  }
  /// With xi and h at random, as a renderer does.
  fiber::FiberEvent begin(const fiber::FiberDirection& wr, RandomStream& random) const {
    const float xi1 = random.next(), xi2 = random.next(), h = 2 * random.next() - 1;
    return model_->begin(id_, wr, xi1, xi2, h);
  }

 private:
  fiber::ModelService learned_;
  std::unique_ptr<fiber::FiberModel> model_;
  fiber::FiberId id_ = 0;
};

inline fiber::FiberSample draw(const fiber::FiberModel& model, const fiber::FiberEvent& event, RandomStream& random) {
  std::array<float, 4> u;
  for (float& x : u) x = random.next();
  return model.sample(event, u);
}

/// Integrals over all directions: of S (green), and of the density of the sampler.
struct Masses {
  double s = 0, pdf = 0;
};

/// On panels_theta x panels_phi panels of 8 x 8 points, theta_i outside, so that a trace at the vertex serves a whole
/// inner integral. Of a model that evaluates().
inline Masses masses(const fiber::FiberModel& model, const fiber::FiberEvent& event, int panels_theta, int panels_phi) {
  constexpr double pi = std::numbers::pi, pole = fiber::half_pi;
  Masses sum;
  visit_points(
      [&](double theta, double weight_theta) {
        visit_points(
            [&](double phi, double weight_phi) {
              const fiber::FiberValue at = model.evaluate(event, {static_cast<float>(theta), static_cast<float>(phi)});
              sum.s += weight_theta * weight_phi * double{at.total().g};
              sum.pdf += weight_theta * weight_phi * double{at.pdf};
            },
            -pi, pi, panels_phi);
      },
      -pole, pole, panels_theta);
  return sum;
}

/// Weights S/Q (luminance) of samples with xi and h at random.
struct Weights {
  double mean = 0, standard_error = 0;
  double variance = 0;  ///< of a weight
  double largest = 0;
};

/// Fiber: OneFiber, or another with its model() and begin(wr, random).
template <class Fiber>
Weights weights(const Fiber& fiber, const fiber::FiberDirection& wr, int samples, std::uint64_t seed) {
  SampleMean mean;
  Weights result;
  RandomStream random(seed);
  for (int i = 0; i < samples; ++i) {
    const fiber::FiberSample sample = draw(fiber.model(), fiber.begin(wr, random), random);
    const double weight = double{luminance(sample.value.total())} / double{sample.value.pdf};
    mean.add(weight);
    result.largest = std::max(result.largest, weight);
  }
  result.mean = mean.mean();
  result.standard_error = mean.standard_error();
  result.variance = samples * mean.standard_error() * mean.standard_error();
  return result;
}

/// Samples of one event against the density that evaluate() returns, on bins x bins equal bins; 8 x 8 points a bin.
inline ChiSquare samples_against_density(const fiber::FiberModel& model, const fiber::FiberEvent& event, int samples,
                                         int bins, std::uint64_t seed) {
  constexpr double pi = std::numbers::pi, pole = fiber::half_pi;
  const auto bin_of = [bins](double x, double from, double width) {
    return static_cast<std::size_t>(std::clamp(static_cast<int>((x - from) / width * bins), 0, bins - 1));
  };
  const auto index = [&](double theta, double phi) {
    return bin_of(theta, -pole, 2 * pole) * static_cast<std::size_t>(bins) + bin_of(phi, -pi, 2 * pi);
  };
  std::vector<double> counts(static_cast<std::size_t>(bins * bins)), expected = counts;
  RandomStream random(seed);
  for (int i = 0; i < samples; ++i) {
    const fiber::FiberDirection wi = draw(model, event, random).wi;
    ++counts[index(double{wi.theta}, double{wi.phi})];
  }
  visit_points(
      [&](double theta, double weight_theta) {
        visit_points(
            [&](double phi, double weight_phi) {
              const fiber::FiberValue at = model.evaluate(event, {static_cast<float>(theta), static_cast<float>(phi)});
              expected[index(theta, phi)] += samples * weight_theta * weight_phi * double{at.pdf};
            },
            -pi, pi, bins);
      },
      -pole, pole, bins);
  return chi_square(counts, expected);
}

}  // namespace tress::test
