#include "fit/row_learner.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "base/pi.h"
#include "fit/known_error.h"
#include "fit/problem.h"

namespace tress::inline v0_2::adaptive {
bool is_legal(const Mixture& fit, int components, double energy) {
  if (fit.component_count > static_cast<std::uint32_t>(components) || !(fit.uniform_weight >= 0)) return false;
  const auto in_bounds = [](float s) { return s >= scale_min && s <= scale_max; };
  const auto is_good = [&](const Component& part) {
    return part.weight >= 0 && part.shape.mu >= -pi_f && part.shape.mu < pi_f && in_bounds(part.shape.s_left) &&
           in_bounds(part.shape.s_right);
  };
  // Up to rounding of nine floats that were scaled and added up, with room to spare.
  return std::ranges::all_of(fit.parts(), is_good) && std::abs(fit.energy() - energy) <= 1e-4 * energy + 1e-30;
}

float FitContext::g(float x) {
  ++g_evaluations;
  ++count;
  return nodes.density(x);
}

void FitContext::publish(const Mixture& mixture) {
  ++fits;
  if (is_legal(mixture, components, nodes.energy())) {
    fit = mixture;
  } else {
    ++bad_fits;
    if (!has_fit) {
      fit = Mixture{};
      fit.uniform_weight = nodes.energy();
    }
  }
  has_fit = true;
}

void FitContext::fill_gaps() {
  for (const float x : gap_fill_azimuths(sketch.pairs(), nodes.blur_rad())) sketch.offer(x, g(x));
}

bool FitContext::test() {
  return stop.run(options, [this] { return largest_error(); });
}

double FitContext::largest_error() {
  const std::span<const float> grid = nodes.grid();
  KnownError error = known_error(fit, nodes, grid);
  if (error.most <= options.epsilon) return error.most;
  const auto step_azimuth = [](std::size_t i, std::size_t n) {
    return wrap_angle(static_cast<float>((static_cast<double>(i) / static_cast<double>(n) - 0.5) * two_pi));
  };
  if (error.seen <= options.epsilon) {
    std::vector<float> finer(2 * grid.size());
    for (std::size_t i = 0; i < finer.size(); ++i) {
      finer[i] = i % 2 == 0 ? grid[i / 2] : g(step_azimuth(i, finer.size()));
      if (i % 2 != 0) sketch.offer(step_azimuth(i, finer.size()), finer[i]);
    }
    error = known_error(fit, nodes, finer);
    if (error.most <= options.epsilon) return error.most;
  }
  for (std::size_t i = 0; i < grid.size(); ++i) sketch.offer(step_azimuth(i, grid.size()), grid[i]);
  return error.most;
}

void RowLearner::before_test(FitContext&) {}
std::optional<std::vector<std::uint64_t>> RowLearner::state() const { return std::nullopt; }
bool RowLearner::set_state(std::span<const std::uint64_t>) { return false; }

}  // namespace tress::inline v0_2::adaptive
