// Step IV of the paper's fit for one sample: the weighted objective in a and b, its derivatives, and where it stands.
#pragma once

#include <cstddef>
#include <vector>

#include "fit/own_eigen.h"
#include "references/learners/ais_columns.h"
#include "references/learners/ais_settings.h"

namespace tress::inline v0_2::adaptive {

/// a_d multiplies the unnormalised p_d (AisShape), a_0 the uniform density.
struct AisParts {
  std::vector<AisShape> shapes;
  std::vector<double> a;  ///< as many, >= 0
  double uniform = 0;     ///< a_0 >= 0, a mass

  double mass(AisBasis basis) const;
};

/// Components [first, last) of the mixture, and whether a_0 is with them: what is moved at a time.
struct AisRange {
  std::size_t first = 0, last = 0;
  bool uniform = false;
};

/// O = sum_i c_i h(g_i || f_i) + tau g(pi) (f(pi) - f(-pi))^2, the second term on the line only. One thread.
class AisProblem {
 public:
  AisProblem(AisDistance distance, AisBasis basis, double tau) : distance_(distance), basis_(basis), tau_(tau) {}

  /// A new sample. cells: c_i >= 0. g_end: g(pi).
  void set_sample(const std::vector<double>& azimuth, const std::vector<double>& g, const std::vector<double>& cells,
                  double g_end);
  /// Moves to `parts`; fills f and the objective.
  void set_parts(const AisParts& parts);

  const AisParts& parts() const { return parts_; }
  double objective() const { return objective_; }
  AisDistance distance() const { return distance_; }
  AisBasis basis() const { return basis_; }

  /// dO/db in the order (mu, ln left, ln right) of each component of the range.
  Eigen::VectorXd shape_gradient(AisRange range) const;
  /// Its Hessian. `exact` adds the second derivatives of p to the part that is never negative.
  Eigen::MatrixXd shape_hessian(AisRange range, bool exact) const;
  /// The diagonal of that part.
  Eigen::VectorXd shape_curvature(AisRange range) const;
  /// dO/da of the range, a_0 last where it is in it; and the Hessian.
  Eigen::VectorXd weight_gradient(AisRange range) const;
  Eigen::MatrixXd weight_hessian(AisRange range) const;

  /// Puts other shapes into the range and moves there if O is less than it was; else nothing is changed.
  bool try_shapes(AisRange range, const std::vector<AisShape>& shapes);
  /// Likewise the weights of the range, a_0 last. `equal_too`: moves if O is no more.
  bool try_weights(AisRange range, const Eigen::VectorXd& a);

  /// Index of the sample where c (g - f) is largest.
  std::size_t largest_shortfall() const;
  double azimuth(std::size_t i) const { return azimuth_[i]; }

 private:
  struct Place {
    std::vector<double> p, first, second;  ///< columns of all components; p has the uniform density as its last
    std::vector<double> f;
  };

  std::size_t count() const { return parts_.shapes.size(); }
  const double* p_column(const Place& place, std::size_t d) const { return place.p.data() + d * stride_; }
  void fill(Place& place, std::size_t d, const AisShape& shape) const;
  double sum_up(Place& place, const AisParts& parts) const;
  void differentiate();
  Eigen::MatrixXd gram(const double* columns, std::size_t columns_count) const;

  AisDistance distance_;
  AisBasis basis_;
  double tau_;
  AisParts parts_;
  double objective_ = 0, end_weight_ = 0;
  std::size_t samples_ = 0, stride_ = 0;     ///< stride: samples, then -pi, pi and their difference, padded
  std::vector<double> azimuth_, g_, cells_;  ///< stride_ long
  std::vector<double> slope_, curvature_;    ///< of O by f_i; the curvature is never negative
  Place here_, there_;
  mutable std::vector<double> scratch_;
};

}  // namespace tress::inline v0_2::adaptive
