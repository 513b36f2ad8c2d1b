// The least squares problem that a fit solves, in double: parameters, residuals and their gradients.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "sketch/sketch.h"
#include "tress/adaptive/mixture.h"

namespace tress::adaptive {

/// Row of the parameter vector of component d; the last entry of all is a_0.
enum ParameterOffset { offset_weight = 0, offset_mu = 1, offset_log_left = 2, offset_log_right = 3, per_component = 4 };

constexpr int max_parameters = per_component * Mixture::max_components + 1;
using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, max_parameters, 1>;
using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, max_parameters, max_parameters>;

constexpr double scale_min = 0.004;  // radians
constexpr double scale_max = 0.5;

/// One component in double: its density and what its gradient needs. x in radians, relative to mu, in [-pi, pi).
struct Shape {
  Shape(double scale_left, double scale_right);
  double left, right;              ///< scales, radians
  double inverse_z;                ///< 1/Z
  double log_z_left, log_z_right;  ///< d ln Z / d ln s of each side

  struct Value {
    double p, d_mu, d_log_left, d_log_right;
  };
  Value value(double x) const;
  double density(double x) const;
};

/// x in (-3 pi, 3 pi) into [-pi, pi].
double wrap_near(double x);

/// The pairs with their cell weights, half the distance between their neighbours on the circle, and the known energy.
class Problem {
 public:
  /// Drops what is not finite or negative and sorts what is not sorted.
  Problem(std::span<const ObservedPair> pairs, double energy);

  int size() const { return static_cast<int>(azimuth_.size()); }
  double energy() const { return energy_; }
  const std::vector<double>& azimuth() const { return azimuth_; }
  const std::vector<double>& g() const { return g_; }
  const std::vector<double>& cell() const { return cell_; }

  /// o = sum w (f - g)^2 + (E - sum a)^2/2 pi. Fills f at the pairs.
  double objective(const Vector& parameters, std::vector<double>& f) const;
  /// As objective; also the normal matrix J^T W J (lower half) and the gradient J^T W r.
  double linearise(const Vector& parameters, Square& normal, Vector& gradient) const;
  /// Least scale of the sides of a component at mu: a quarter of the distance to the second sample on that side,
  /// within [scale_min, scale_max].
  std::array<double, 2> scale_floors(double mu) const;

 private:
  double energy_;
  std::vector<double> azimuth_, g_, cell_;
};

/// Moves `parameters` to a local minimum of the objective within the bounds, at most `iterations` steps.
/// Returns the objective there; never above the one at the start.
double levenberg_marquardt(const Problem& problem, Vector& parameters, int iterations);

}  // namespace tress::adaptive
