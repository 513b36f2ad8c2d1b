#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "learner/problem.h"

namespace tress::adaptive {
namespace {

constexpr double lambda_start = 1e-3;
constexpr double lambda_success = 0.2;
constexpr double lambda_failure = 6;
constexpr double lambda_hopeless = 1e7;
constexpr double largest_turn = 0.6;      // of mu in one step, radians
constexpr double largest_widening = 0.7;  // of ln s in one step
constexpr double enough = 1e-4;           // relative decrease below which a step counts as the last

// Bounds of one step from `at`: weights stay >= 0, scales within their floors, and no step is too bold.
void step_bounds(const Problem& problem, const Vector& at, Vector& low, Vector& high) {
  const auto last = at.size() - 1;
  low.resize(at.size());
  high.resize(at.size());
  for (Eigen::Index c = 0; c < last; c += per_component) {
    low[c + offset_weight] = -at[c + offset_weight];
    high[c + offset_weight] = HUGE_VAL;
    low[c + offset_mu] = -largest_turn;
    high[c + offset_mu] = largest_turn;
    const auto floors = problem.scale_floors(at[c + offset_mu]);
    for (int side = 0; side < 2; ++side) {
      const auto i = c + offset_log_left + side;
      low[i] = std::clamp(std::log(floors[static_cast<std::size_t>(side)]) - at[i], -largest_widening, 0.0);
      high[i] = std::clamp(std::log(scale_max) - at[i], 0.0, largest_widening);
    }
  }
  low[last] = -at[last];
  high[last] = HUGE_VAL;
}

// matrix x = right, from the lower half. What is past `count` in the padding stays 0, and is finite above the diagonal.
Vector solved(const Square& matrix, const Vector& right) {
  constexpr std::size_t leading = padded_size(max_parameters);
  const auto count = right.size();
  alignas(64) std::array<double, leading * max_parameters> columns;
  alignas(64) std::array<double, leading> x{};
  for (Eigen::Index j = 0; j < count; ++j) {
    double* column = columns.data() + leading * static_cast<std::size_t>(j);
    std::fill_n(column, padded_size(static_cast<std::size_t>(count)), 0.0);
    for (Eigen::Index i = j; i < count; ++i) column[i] = matrix(i, j);
  }
  std::copy_n(right.data(), count, x.data());
  solve_in_place(columns.data(), leading, static_cast<std::size_t>(count), x.data());
  Vector solution(count);
  std::copy_n(x.data(), count, solution.data());
  return solution;
}

// Minimises the damped quadratic within the bounds: what leaves them is held there and the rest solved again.
Vector bounded_step(const Square& normal, const Vector& gradient, double lambda, const Vector& low,
                    const Vector& high) {
  const auto count = gradient.size();
  const double least = 1e-12 * normal.diagonal().maxCoeff() + 1e-300;
  Square damped = normal;
  for (Eigen::Index i = 0; i < count; ++i) damped(i, i) += lambda * normal(i, i) + least;
  Vector right = -gradient;
  Vector step = solved(damped, right);
  std::array<bool, max_parameters> held{};
  for (int round = 0; round < 3; ++round) {
    bool changed = false;
    for (Eigen::Index i = 0; i < count; ++i) {
      if (held[static_cast<std::size_t>(i)] || (step[i] >= low[i] && step[i] <= high[i])) continue;
      held[static_cast<std::size_t>(i)] = changed = true;
      const double fixed = std::clamp(std::isfinite(step[i]) ? step[i] : 0.0, low[i], high[i]);
      for (Eigen::Index j = 0; j < count; ++j) {
        double& coupling = i > j ? damped(i, j) : damped(j, i);
        if (j == i) continue;
        if (!held[static_cast<std::size_t>(j)]) right[j] -= coupling * fixed;
        coupling = 0;
      }
      damped(i, i) = 1;
      right[i] = fixed;
    }
    if (!changed) break;
    step = solved(damped, right);
  }
  for (Eigen::Index i = 0; i < count; ++i) {
    step[i] = std::isfinite(step[i]) ? std::clamp(step[i], low[i], high[i]) : 0.0;
  }
  return step;
}

// After a step: mu back into the circle, scales above the floors of the new place.
void settle(const Problem& problem, Vector& at) {
  for (Eigen::Index c = 0; c + 1 < at.size(); c += per_component) {
    at[c + offset_mu] = wrap_near(at[c + offset_mu]);
    const auto floors = problem.scale_floors(at[c + offset_mu]);
    for (int side = 0; side < 2; ++side) {
      double& log_scale = at[c + offset_log_left + side];
      log_scale = std::clamp(log_scale, std::log(floors[static_cast<std::size_t>(side)]), std::log(scale_max));
    }
  }
}

}  // namespace

double levenberg_marquardt(const Problem& problem, Vector& parameters, int iterations, Problem::Linearisation& work) {
  Square normal;
  Vector gradient, low, high;
  double best = problem.linearise(parameters, work);
  double lambda = lambda_start;
  for (int i = 0; i < iterations; ++i) {
    problem.normal_equations(work, parameters.size(), normal, gradient);
    step_bounds(problem, parameters, low, high);
    double reached = best;
    Vector trial;
    while (lambda < lambda_hopeless) {
      const Vector step = bounded_step(normal, gradient, lambda, low, high);
      // To first order, and a damped step gains less: nothing is left that is worth a try.
      if (-2 * gradient.dot(step) < enough * best) return best;
      trial = parameters + step;
      settle(problem, trial);
      reached = problem.linearise(trial, work);  // most trials are taken, and then this is the next point's
      if (reached < best) break;
      lambda *= lambda_failure;
    }
    if (!(reached < best)) break;
    parameters = trial;
    const bool last = best - reached < enough * best;
    best = reached;
    if (last) break;
    lambda *= lambda_success;
  }
  return best;
}

}  // namespace tress::adaptive
