#include "fit/row_learner.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "fit/problem.h"

namespace tress::adaptive {
namespace {

/// Of nine floats that were scaled to the energy and added up, with room to spare.
bool is_mass(double mass, double energy) { return std::abs(mass - energy) <= 1e-4 * energy + 1e-30; }

constexpr int most_refinements = 3;
constexpr double least_seen = 1.0 / 32;  // of epsilon: what may hide between two pairs

/// From pair i to the next on the circle.
double gap_after(const std::vector<ObservedPair>& pairs, std::size_t i) {
  return i + 1 < pairs.size()
             ? static_cast<double>(pairs[i + 1].azimuth) - static_cast<double>(pairs[i].azimuth)
             : static_cast<double>(pairs[0].azimuth) + 2 * std::numbers::pi - static_cast<double>(pairs[i].azimuth);
}

}  // namespace

bool is_legal(const Mixture& fit, int components, double energy) {
  if (fit.component_count > static_cast<std::uint32_t>(components) || !(fit.uniform_weight >= 0)) return false;
  const auto in_bounds = [](float s) { return s >= scale_min && s <= scale_max; };
  const auto is_good = [&](const Component& part) {
    return part.weight >= 0 && part.shape.mu >= -std::numbers::pi_v<float> &&
           part.shape.mu < std::numbers::pi_v<float> && in_bounds(part.shape.s_left) && in_bounds(part.shape.s_right);
  };
  return std::ranges::all_of(fit.parts(), is_good) && is_mass(fit.energy(), energy);
}

bool is_legal(const KnotDensity& table, double energy) {
  const auto is_good = [](const Knot& knot) { return knot.density >= 0 && std::isfinite(knot.density); };
  return std::ranges::all_of(table.knots(), is_good) && is_mass(table.energy(), energy);
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

void FitContext::close(KnotDensity table, double objective) {
  ++fits;
  has_fit = false;
  const bool good = is_legal(table, nodes.energy());
  bad_fits += good ? 0 : 1;
  stop.judge(good ? objective : static_cast<double>(std::numeric_limits<float>::max()), options);
  if (stop.verdict() == StopTest::Verdict::converged) knots = std::make_unique<const KnotDensity>(std::move(table));
}

ObservedPair FitContext::draw_own() {
  const float share = options.uniform_share_open;
  const float x = fit.sample(random.next(), share);
  const float value = g(x);
  stop.add(static_cast<double>(value) - fit.density(x), fit.proposal_density(x, share), nodes.variation());
  return {x, value};
}

void FitContext::fill_gaps() {
  for (const float x : gap_fill_azimuths(sketch.pairs(), nodes.blur_rad())) sketch.offer(x, g(x));
}

bool FitContext::test() {
  return stop.run(options, [this] { return held_residual(); });
}

double FitContext::held_residual() {
  fill_gaps();
  for (int round = 0; round < most_refinements && look_closer(); ++round) {
  }
  const std::vector<ObservedPair> pairs = sketch.pairs();
  double sum = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const double off = static_cast<double>(pairs[i].g) - static_cast<double>(fit.density(pairs[i].azimuth));
    sum += 0.5 * (gap_after(pairs, i) + gap_after(pairs, i > 0 ? i - 1 : pairs.size() - 1)) * off * off;
  }
  double factor = 1;
  if (fitted_to_pairs) {
    const auto n = static_cast<double>(pairs.size());
    factor = n / std::max(n - 4.0 * fit.component_count - 1, n / 4);
  }
  return factor * factor * sum / static_cast<double>(nodes.variation());
}

bool FitContext::look_closer() {
  const std::vector<ObservedPair> pairs = sketch.pairs();
  const double worth = options.epsilon * static_cast<double>(nodes.variation()) * least_seen;
  bool asked = false;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const double gap = gap_after(pairs, i);
    if (gap <= nodes.blur_rad()) continue;
    const float x = wrap_angle(static_cast<float>(pairs[i].azimuth + gap / 2));
    const double here = pairs[i].g, next = pairs[(i + 1) % pairs.size()].g, between = fit.density(x);
    const double swing = std::max({here, next, between}) - std::min({here, next, between});
    if (gap * swing * swing <= worth) continue;
    sketch.offer(x, g(x));
    asked = true;
  }
  return asked;
}

void RowLearner::before_test(FitContext&) {}

}  // namespace tress::adaptive
