// Non-negative least squares for a handful of unknowns.
#pragma once

#include "fit/own_eigen.h"

namespace tress::inline v0_2::adaptive {

/// Returns the x >= 0 that minimises x^T G x / 2 - r^T x, G symmetric and positive semidefinite (P^T W P of a
/// regression), r = P^T W g. Uses Lawson and Hanson's active set on the normal equations (Bro and de Jong 1997).
/// Deterministic; finite for finite input. A column that adds nothing to the others gets 0.
Eigen::VectorXd non_negative_least_squares(const Eigen::MatrixXd& gram, const Eigen::VectorXd& right);

}  // namespace tress::inline v0_2::adaptive
