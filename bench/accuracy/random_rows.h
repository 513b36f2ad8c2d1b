// The random rows of the elliptical target that learners are measured on, and what their errors are stated in.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "fiber/row_axes.h"
#include "tress/adaptive/target.h"
#include "tress/adaptive/traced_nodes.h"
#include "tress/base/random.h"
#include "tress/fiber/elliptical_model.h"

namespace tress::bench {

/// Domains: wide, sigma 5..25 degrees; hard, sigma 1..10 on the grid sigma of the program (at least 4 degrees); narrow,
/// sigma 1..10 as it is; e 0.7..1. whole: sigma 1..45, e 0.5..1, all that the program has grids for. eta 1.55, lobes
/// and nodes of the slice uniform, E_p >= 0.001 (less is uniform in the program). `split`: GLINT and the rest of TRT
/// instead of TT, TRT and TRRT.
class RandomRows {
 public:
  RandomRows(std::uint64_t seed, std::string domain, bool split)
      : random_(seed, 2000), domain_(std::move(domain)), split_(split) {}

  struct Row {
    adaptive::SliceDescription description;  ///< of one node: publish() then walks over no others
    std::vector<adaptive::TracedRay> rays;
  };

  Row next(const adaptive::Target& target) {
    constexpr double degree = std::numbers::pi / 180, least_energy = 1e-3;
    for (;;) {
      const int slice = split_ ? (random_.next() < 0.5f ? fiber::glint_slice : fiber::trt_rest_slice)
                               : 1 + static_cast<int>(between(0, 3));
      const bool whole = domain_ == "whole";
      const auto e = static_cast<float>(between(whole ? 0.5 : 0.7, 1));
      auto sigma = static_cast<float>((whole               ? between(1, 45)
                                       : domain_ == "wide" ? between(5, 25)
                                                           : between(1, 10)) *
                                      degree);
      if (domain_ == "hard") sigma = std::max(sigma, fiber::smallest_grid_sigma);
      // The key, and so the target, is the program's.
      Row row{fiber::elliptical_slice(slice, 1.55f, e, sigma), {}};
      const auto pick = [&](std::vector<float>& axis) {
        axis = {axis[static_cast<std::size_t>(between(0, static_cast<double>(axis.size())))]};
      };
      pick(row.description.axis_a);
      pick(row.description.axis_b);
      target.trace(row.description, row.description.axis_a[0], row.description.axis_b[0], row.rays);
      double energy = 0;
      for (const adaptive::TracedRay& ray : row.rays) energy += ray.weight;
      if (energy >= least_energy) return row;
    }
  }

 private:
  double between(double low, double high) { return low + (high - low) * static_cast<double>(random_.next()); }

  RandomStream random_;
  std::string domain_;
  bool split_;
};

/// Integral of (g - f)^2 over what the objective is relative to, by the trapezoid rule, a sixth of sigma apart. `fit`:
/// whatever has a density.
template <class Fit>
double true_objective(const Fit& fit, const adaptive::TracedNodes& nodes) {
  constexpr double pi = std::numbers::pi;
  const auto points = static_cast<int>(std::max(720.0, std::ceil(12 * pi / static_cast<double>(nodes.blur_rad()))));
  double sum = 0;
  for (int i = 0; i < points; ++i) {
    const auto x = static_cast<float>(-pi + 2 * pi * i / points);
    const double r = static_cast<double>(nodes.density(x)) - static_cast<double>(fit.density(x));
    sum += r * r * 2 * pi / points;
  }
  return sum / static_cast<double>(nodes.variation());
}

inline double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::ranges::sort(values);
  const double rank = std::ceil(share * static_cast<double>(values.size()));
  return values[static_cast<std::size_t>(std::max(rank, 1.0)) - 1];
}

inline nlohmann::json spread(const std::vector<double>& values) {
  return {{"p50", quantile(values, .5)},
          {"p90", quantile(values, .9)},
          {"p99", quantile(values, .99)},
          {"max", quantile(values, 1)}};
}

}  // namespace tress::bench
