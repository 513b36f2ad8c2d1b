// The rows of bench_azimuthal_rivals with what is true of them, and what every rival reports.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "fiber/fourier_reference.h"
#include "models/registry.h"
#include "random_rows.h"

namespace tress::bench {

inline constexpr double pi = std::numbers::pi;
inline constexpr float share = 0.02f;  ///< of the proposal, uniform
inline constexpr float eta = 1.55f;
inline const glm::vec3 brown(0.545f, 0.906f, 1.781f), mix(0.5f, 0.3f, 0.2f), clear(0.0f);

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
inline std::vector<double> azimuths(double sigma) {
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
  RandomRows::Row random;
  int p = 1;
  float e = 1, sigma = 1, phi_r = 0, theta_d = 0;
  Reference own, circle;

  explicit Row(RandomRows::Row row)
      : random(std::move(row)),
        p(fiber::slice_order(static_cast<int>(random.description.key.lobe))),
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
    RandomRows random(1, name == "hard" ? "narrow" : name, false);
    for (int i = 0; i < count; ++i) rows.emplace_back(random.next(*target));
  }
};

struct Answer {
  glm::vec3 density{0.0f};
  float pdf = 0, x = 0;
};

/// What all rivals report beside their times.
struct RivalFacts {
  std::vector<double> errors, circle_errors;  ///< of the rows that it has
  double parts = 0;                           ///< components or knots, mean
  std::size_t rows = 0;
};

}  // namespace tress::bench
