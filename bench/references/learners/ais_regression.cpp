#include "references/learners/ais_regression.h"

#include "references/learners/nnls.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr int halvings = 8;

}  // namespace

void regress_weights(AisProblem& problem, AisRange range) {
  const auto size = static_cast<Eigen::Index>(range.last - range.first);
  Eigen::VectorXd now(size + (range.uniform ? 1 : 0));
  for (Eigen::Index i = 0; i < size; ++i) now[i] = problem.parts().a[range.first + static_cast<std::size_t>(i)];
  if (range.uniform) now[size] = problem.parts().uniform;
  if (now.size() == 0) return;
  const Eigen::MatrixXd hessian = problem.weight_hessian(range);
  const Eigen::VectorXd best = non_negative_least_squares(hessian, hessian * now - problem.weight_gradient(range));
  if (!best.allFinite()) return;
  double way = 1;
  for (int i = 0; i < halvings && !problem.try_weights(range, now + way * (best - now)); ++i) way /= 2;
}

}  // namespace tress::inline v0_2::adaptive
