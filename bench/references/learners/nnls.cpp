#include "references/learners/nnls.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace tress::inline v0_2::adaptive {
namespace {

// Solves for the free unknowns alone; the others stay 0. The matrix is scaled to a unit diagonal; a ridge keeps nearly
// equal columns apart.
Eigen::VectorXd solve_free(const Eigen::MatrixXd& gram, const Eigen::VectorXd& right, const std::vector<bool>& free) {
  std::vector<Eigen::Index> at;
  for (std::size_t i = 0; i < free.size(); ++i) {
    if (free[i]) at.push_back(static_cast<Eigen::Index>(i));
  }
  const auto n = static_cast<Eigen::Index>(at.size());
  Eigen::MatrixXd reduced(n, n);
  Eigen::VectorXd scale(n), solution(n);
  for (Eigen::Index i = 0; i < n; ++i) scale[i] = 1 / std::sqrt(gram(at[i], at[i]));
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) reduced(i, j) = gram(at[i], at[j]) * scale[i] * scale[j];
    reduced(i, i) += 1e-12;
    solution[i] = right[at[i]] * scale[i];
  }
  solution = reduced.ldlt().solve(solution);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(right.size());
  for (Eigen::Index i = 0; i < n; ++i) x[at[i]] = solution[i] * scale[i];
  return x;
}

}  // namespace

Eigen::VectorXd non_negative_least_squares(const Eigen::MatrixXd& gram, const Eigen::VectorXd& right) {
  const auto n = right.size();
  Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
  std::vector<bool> free(static_cast<std::size_t>(n), false);
  const auto is_free = [&](Eigen::Index i) { return free[static_cast<std::size_t>(i)]; };
  const double least = 1e-12 * std::max(right.cwiseAbs().maxCoeff(), std::numeric_limits<double>::min());
  // Each round frees the unknown that gains most. Three rounds for each unknown are far more than are ever needed.
  for (Eigen::Index round = 0; round < 3 * n; ++round) {
    const Eigen::VectorXd gain = right - gram * x;
    Eigen::Index next = -1;
    for (Eigen::Index i = 0; i < n; ++i) {
      if (!is_free(i) && gram(i, i) > 0 && gain[i] > least && (next < 0 || gain[i] > gain[next])) next = i;
    }
    if (next < 0) break;
    free[static_cast<std::size_t>(next)] = true;
    Eigen::VectorXd trial = solve_free(gram, right, free);
    for (Eigen::Index inner = 0; inner < n; ++inner) {
      double way = 1;
      for (Eigen::Index i = 0; i < n; ++i) {
        if (is_free(i) && !(trial[i] > 0)) way = std::min(way, x[i] / std::max(x[i] - trial[i], 1e-300));
      }
      if (way >= 1) break;
      x += way * (trial - x);
      for (Eigen::Index i = 0; i < n; ++i) {
        if (is_free(i) && !(trial[i] > 0) && x[i] <= 1e-14 * x.maxCoeff()) free[static_cast<std::size_t>(i)] = false;
        if (!is_free(i)) x[i] = 0;
      }
      trial = solve_free(gram, right, free);
    }
    if (!trial.allFinite()) break;
    x = trial.cwiseMax(0);
  }
  return x;
}

}  // namespace tress::inline v0_2::adaptive
