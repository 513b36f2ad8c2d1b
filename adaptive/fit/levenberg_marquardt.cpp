#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "fit/problem.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr double lambda_start = 1e-3;
constexpr double lambda_success = 0.2;
constexpr double lambda_failure = 6;
constexpr double lambda_hopeless = 1e7;
constexpr double largest_turn = 0.6;      // change of mu in one step, radians
constexpr double largest_widening = 0.7;  // change of ln s in one step
constexpr double enough = 3e-3;           // relative decrease below which a step is the last
constexpr int most_rounds = 3;            // how often a step is solved again where it meets bounds
constexpr double at_bound = 1e-9;         // distance below which a parameter counts as at its bound

// Logarithms of the least scales, by side and component, as settle() sets them.
using Floors = std::array<double, 2 * Mixture::max_components>;

// Sets the bounds of one step from `at`: weights stay >= 0, scales stay above their floors, and the step is not too
// large.
void step_bounds(const Vector& at, const Floors& floors, Vector& low, Vector& high) {
  const auto last = at.size() - 1;
  low.resize(at.size());
  high.resize(at.size());
  for (Eigen::Index c = 0; c < last; c += per_component) {
    low[c + offset_weight] = -at[c + offset_weight];
    high[c + offset_weight] = HUGE_VAL;
    low[c + offset_mu] = -largest_turn;
    high[c + offset_mu] = largest_turn;
    for (int side = 0; side < 2; ++side) {
      const auto i = c + offset_log_left + side;
      low[i] = std::clamp(floors[static_cast<std::size_t>(c / 2 + side)] - at[i], -largest_widening, 0.0);
      high[i] = std::clamp(std::log(scale_max) - at[i], 0.0, largest_widening);
    }
  }
  low[last] = -at[last];
  high[last] = HUGE_VAL;
}

/// Indices of parameters, ascending.
struct Chosen {
  std::array<Eigen::Index, max_parameters> at;
  std::size_t count = 0;
  void add(Eigen::Index i) { at[count++] = i; }
};

// Solves the damped system for the free parameters, given the step of all others.
Vector solved(const Square& normal, const Vector& gradient, double lambda, const Chosen& free, const Vector& known) {
  constexpr std::size_t leading = padded_size(max_parameters);
  // The count is never larger; the bound is here because g++ 14 warns of what the loops would do otherwise.
  const std::size_t count = std::min<std::size_t>(free.count, max_parameters);
  alignas(64) std::array<double, leading * max_parameters> columns;
  alignas(64) std::array<double, leading> x{};
  const double least = 1e-12 * normal.diagonal().maxCoeff() + 1e-300;
  for (std::size_t j = 0; j < count; ++j) {
    // Copies the lower half. The padding past the end must be 0, and what is above the diagonal finite.
    double* column = columns.data() + leading * j;
    const double* from = normal.data() + normal.rows() * free.at[j];
    for (std::size_t i = j / kernel_lanes * kernel_lanes; i < j; ++i) column[i] = 0;
    for (std::size_t i = j; i < count; ++i) column[i] = from[free.at[i]];
    for (std::size_t i = count; i < padded_size(count); ++i) column[i] = 0;
    column[j] += lambda * column[j] + least;
    x[j] = -gradient[free.at[j]];
  }
  for (Eigen::Index h = 0; h < known.size(); ++h) {
    if (known[h] == 0) continue;
    for (std::size_t i = 0; i < count; ++i) {
      x[i] -= known[h] * (free.at[i] > h ? normal(free.at[i], h) : normal(h, free.at[i]));
    }
  }
  solve_in_place(columns.data(), leading, count, x.data());
  return Eigen::Map<const Vector>(x.data(), static_cast<Eigen::Index>(count));
}

// Minimises the damped quadratic within the bounds. A parameter at a bound that would leave it stays; one that crosses
// a bound is held there, and the rest is solved again.
Vector bounded_step(const Square& normal, const Vector& gradient, double lambda, const Vector& low,
                    const Vector& high) {
  Vector step = Vector::Zero(gradient.size());
  Chosen free;
  for (Eigen::Index i = 0; i < gradient.size(); ++i) {
    const bool stays = (gradient[i] > 0 && low[i] > -at_bound) || (gradient[i] < 0 && high[i] < at_bound);
    if (!stays) free.add(i);
  }
  for (int round = 0; round <= most_rounds && free.count > 0; ++round) {
    const Vector x = solved(normal, gradient, lambda, free, step);
    Chosen inside;
    for (std::size_t k = 0; k < free.count; ++k) {
      const Eigen::Index i = free.at[k];
      const double wanted = x[static_cast<Eigen::Index>(k)];
      if (wanted >= low[i] && wanted <= high[i]) {
        inside.add(i);
        continue;
      }
      step[i] = std::clamp(std::isfinite(wanted) ? wanted : 0.0, low[i], high[i]);
    }
    if (inside.count < free.count && round < most_rounds) {
      free = inside;
      continue;
    }
    for (std::size_t k = 0, next = 0; k < free.count; ++k) {
      if (next == inside.count || inside.at[next] != free.at[k]) continue;
      step[free.at[k]] = x[static_cast<Eigen::Index>(k)];
      ++next;
    }
    break;
  }
  return step;
}

static_assert(per_component == 4);  // the floors of component c begin at c / 2
void set_floors(const Problem& problem, const Vector& at, Eigen::Index c, Floors& floors) {
  const auto [left, right] = problem.scale_floors(at[c + offset_mu]);
  floors[static_cast<std::size_t>(c / 2)] = std::log(left);
  floors[static_cast<std::size_t>(c / 2 + 1)] = std::log(right);
}

// Wraps mu into the circle and raises scales to the floors at the new mu.
void settle(const Problem& problem, Vector& at, Floors& floors) {
  for (Eigen::Index c = 0; c + 1 < at.size(); c += per_component) {
    at[c + offset_mu] = wrap_near(at[c + offset_mu]);
    set_floors(problem, at, c, floors);
    for (int side = 0; side < 2; ++side) {
      double& log_scale = at[c + offset_log_left + side];
      log_scale = std::clamp(log_scale, floors[static_cast<std::size_t>(c / 2 + side)], std::log(scale_max));
    }
  }
}

}  // namespace

double levenberg_marquardt(const Problem& problem, Vector& parameters, int iterations, Problem::Linearisation& work) {
  Square normal;
  Vector gradient, low, high;
  Floors floors{}, trial_floors{};
  settle(problem, parameters, floors);  // a start may be narrower than these pairs can resolve
  double best = problem.linearise(parameters, work);
  double lambda = lambda_start;
  for (int i = 0; i < iterations; ++i) {
    problem.normal_equations(work, parameters.size(), normal, gradient);
    step_bounds(parameters, floors, low, high);
    double reached = best;
    Vector trial;
    while (lambda < lambda_hopeless) {
      const Vector step = bounded_step(normal, gradient, lambda, low, high);
      // This is the gain to first order, and a damped step gains less: no further step is worth a try.
      if (-2 * gradient.dot(step) < enough * best) return best;
      trial = parameters + step;
      settle(problem, trial, trial_floors);
      reached = problem.linearise(trial, work);  // most trials are accepted: it serves the next step
      if (reached < best) break;
      lambda *= lambda_failure;
    }
    if (!(reached < best)) break;
    parameters = trial;
    floors = trial_floors;
    const bool last = best - reached < enough * best;
    best = reached;
    if (last) break;
    lambda *= lambda_success;
  }
  return best;
}

}  // namespace tress::inline v0_2::adaptive
