// The least squares problem that a fit solves, in double: parameters, residuals and their gradients.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "fit/kernels.h"
#include "fit/own_eigen.h"
#include "observations/sketch.h"
#include "tress/adaptive/mixture.h"

namespace tress::inline v0_2::adaptive {

/// The places of component d's numbers within its part of the parameter vector; the last entry of the vector is a_0.
enum ParameterOffset { offset_weight = 0, offset_mu = 1, offset_log_left = 2, offset_log_right = 3, per_component = 4 };

constexpr int max_parameters = per_component * Mixture::max_components + 1;
using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, max_parameters, 1>;
using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, max_parameters, max_parameters>;

constexpr double scale_min = 0.004;  // radians
constexpr double scale_max = 0.5;

/// Wraps x in (-3 pi, 3 pi) into [-pi, pi].
double wrap_near(double x);

/// The component whose parameters start at `at`.
Shape shape_at(const Vector& parameters, Eigen::Index at);

/// Returns the mixture of these parameters, with its scales within bounds. weight(a): the mass to publish for a
/// parameter a.
template <class Weight>
Mixture mixture_from(const Vector& parameters, const Weight& weight) {
  const auto scale = [](double log_s) {
    return std::clamp(static_cast<float>(std::exp(log_s)), static_cast<float>(scale_min),
                      static_cast<float>(scale_max));
  };
  Mixture mixture;
  for (Eigen::Index at = 0; at + 1 < parameters.size(); at += per_component) {
    Component& part = mixture.components[mixture.component_count++];
    part.weight = weight(parameters[at + offset_weight]);
    part.shape = {wrap_angle(static_cast<float>(parameters[at + offset_mu])), scale(parameters[at + offset_log_left]),
                  scale(parameters[at + offset_log_right])};
  }
  mixture.uniform_weight = weight(parameters[parameters.size() - 1]);
  return mixture;
}

/// The pairs with their cell weights (half the distance between their neighbours on the circle) and the known energy.
class Problem {
 public:
  /// Drops values that are negative or not finite, and sorts the pairs if they are not sorted.
  Problem(std::span<const ObservedPair> pairs, double energy);

  int size() const { return static_cast<int>(size_); }
  double energy() const { return energy_; }
  /// The azimuths, ascending.
  std::span<const double> azimuth() const { return {azimuth_.data(), size_}; }
  std::span<const double> g() const { return {g_.data(), size_}; }
  std::span<const double> cell() const { return {cell_.data(), size_}; }

  /// The padded length for the kernels; arrays of Linearisation are as long.
  std::size_t padded() const { return azimuth_.size(); }

  /// Returns o = sum w (f - g)^2 + (E - sum a)^2/2 pi. Fills f at the pairs (padded() long).
  double objective(const Vector& parameters, std::vector<double>& f) const;

  /// f and its derivatives at the pairs. It keeps its memory from one use to the next.
  struct Linearisation {
    std::vector<double> f, columns, scratch;
    double missing = 0;  ///< E - sum a
  };
  /// Returns the objective, and fills `at` for the normal equations.
  double linearise(const Vector& parameters, Linearisation& at) const;
  /// Computes the normal matrix J^T W J (lower half) and the gradient J^T W r at `at`, of `count` parameters.
  void normal_equations(Linearisation& at, Eigen::Index count, Square& normal, Vector& gradient) const;

  /// Projects the residual g - f on a component of this shape. f: padded() long.
  Projection project(const Shape& shape, const std::vector<double>& f) const;

  /// The least scales of the two sides of a component at mu: a quarter of the distance to the second sample on that
  /// side, within [scale_min, scale_max].
  std::array<double, 2> scale_floors(double mu) const;

 private:
  double energy_;
  std::size_t size_ = 0;
  std::vector<double> azimuth_, g_, cell_;
};

/// Moves `parameters` to a local minimum of the objective within the bounds, in at most `iterations` steps. Returns the
/// objective there, which is never above that of the start with its scales raised to their floors. `work` is scratch
/// memory.
double levenberg_marquardt(const Problem& problem, Vector& parameters, int iterations, Problem::Linearisation& work);

}  // namespace tress::inline v0_2::adaptive
