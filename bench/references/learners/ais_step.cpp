#include "references/learners/ais_step.h"

#include <algorithm>
#include <cmath>

#include "base/pi.h"
#include "fit/problem.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr double damping_start = 1e-2, damping_success = 0.2, damping_failure = 8;
constexpr double damping_least = 1e-8, damping_hopeless = 1e6;
constexpr double length_start = 1, length_success = 2, length_failure = 0.25, length_hopeless = 1e-9;
constexpr double largest_turn = 0.6;      // of mu in one step, radians
constexpr double largest_widening = 0.7;  // of ln s in one step

AisShape moved(const AisShape& from, double turn, double left, double right, AisBasis basis) {
  const auto widened = [](double scale, double by) {
    return std::clamp(scale * std::exp(std::clamp(by, -largest_widening, largest_widening)), scale_min, scale_max);
  };
  const double mu = from.mu + std::clamp(turn, -largest_turn, largest_turn);
  return {basis == AisBasis::line ? std::clamp(mu, -pi, pi) : wrap_near(mu), widened(from.left, left),
          widened(from.right, right)};
}

std::vector<AisShape> moved(const AisProblem& problem, AisRange range, const Eigen::VectorXd& step) {
  std::vector<AisShape> shapes;
  Eigen::Index at = 0;
  for (std::size_t d = range.first; d < range.last; ++d, at += ais_first)
    shapes.push_back(moved(problem.parts().shapes[d], step[at], step[at + 1], step[at + 2], problem.basis()));
  return shapes;
}

// Scales at a bound that the descent would cross: they stay.
std::vector<bool> held(const AisProblem& problem, AisRange range, const Eigen::VectorXd& gradient) {
  std::vector<bool> stays(static_cast<std::size_t>(gradient.size()), false);
  for (std::size_t d = range.first; d < range.last; ++d) {
    const AisShape& shape = problem.parts().shapes[d];
    const std::size_t at = ais_first * (d - range.first);
    const auto bound = [&](std::size_t i, double scale) {
      const double slope = gradient[static_cast<Eigen::Index>(i)];
      stays[i] = (scale >= scale_max * (1 - 1e-9) && slope < 0) || (scale <= scale_min * (1 + 1e-9) && slope > 0);
    };
    bound(at + 1, shape.left);
    bound(at + 2, shape.right);
  }
  return stays;
}

}  // namespace

AisStepper::AisStepper(AisStep kind, std::size_t components)
    : kind_(kind), memory_(components + 1, kind == AisStep::newton ? damping_start : length_start) {}

bool AisStepper::step(AisProblem& problem, AisRange range) {
  const bool complete = range.last - range.first > 1 || problem.parts().shapes.size() == 1;
  double& memory = memory_[complete ? memory_.size() - 1 : range.first];
  return kind_ == AisStep::newton ? newton(problem, range, memory) : gradient(problem, range, memory);
}

bool AisStepper::newton(AisProblem& problem, AisRange range, double& damping) const {
  Eigen::VectorXd gradient = problem.shape_gradient(range);
  const std::vector<bool> stays = held(problem, range, gradient);
  Eigen::MatrixXd hessian = problem.shape_hessian(range, true);
  // What the damping is in units of: the part of the Hessian that is never negative.
  Eigen::VectorXd scale = problem.shape_curvature(range);
  scale.array() += 1e-9 * scale.maxCoeff() + 1e-300;
  for (Eigen::Index i = 0; i < gradient.size(); ++i) {
    if (!stays[static_cast<std::size_t>(i)]) continue;
    hessian.row(i).setZero();
    hessian.col(i).setZero();
    hessian(i, i) = scale[i];
    gradient[i] = 0;
  }
  if (!gradient.allFinite() || !hessian.allFinite()) return false;
  for (; damping < damping_hopeless; damping *= damping_failure) {
    Eigen::MatrixXd damped = hessian;
    damped.diagonal() += damping * scale;
    const Eigen::LLT<Eigen::MatrixXd> factors(damped);
    if (factors.info() != Eigen::Success) continue;  // not positive: no minimum that way
    if (!problem.try_shapes(range, moved(problem, range, -factors.solve(gradient)))) continue;
    damping = std::max(damping * damping_success, damping_least);
    return true;
  }
  damping = damping_start;
  return false;
}

bool AisStepper::gradient(AisProblem& problem, AisRange range, double& length) const {
  Eigen::VectorXd descent = -problem.shape_gradient(range);
  const std::vector<bool> stays = held(problem, range, -descent);
  double largest = 0;
  for (std::size_t i = 0; i < stays.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    const AisShape& shape = problem.parts().shapes[range.first + i / ais_first];
    const double unit = std::min(shape.left, shape.right);
    if (i % ais_first == 0) descent[at] *= unit;  // the slope by mu/s; the step below is then in mu again
    if (stays[i]) descent[at] = 0;
    largest = std::max(largest, std::abs(descent[at]));
  }
  if (!(largest > 0) || !std::isfinite(largest)) return false;
  descent /= largest;
  for (std::size_t i = 0; i < stays.size(); i += ais_first) {
    const AisShape& shape = problem.parts().shapes[range.first + i / ais_first];
    descent[static_cast<Eigen::Index>(i)] *= std::min(shape.left, shape.right);
  }
  for (; length > length_hopeless; length *= length_failure) {
    if (!problem.try_shapes(range, moved(problem, range, length * descent))) continue;
    length = std::min(length * length_success, length_start);
    return true;
  }
  length = length_start;
  return false;
}

}  // namespace tress::inline v0_2::adaptive
