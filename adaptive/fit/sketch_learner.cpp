#include "fit/sketch_learner.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "base/pi.h"
#include "fit/fit_mixture.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr std::uint64_t count_before_restart = 64;
constexpr std::size_t most_refined = 12;  // azimuths after a failed test
constexpr double refined_gap = 0.5;       // in blurs: closer pairs carry the same information

}  // namespace

constinit const Learner sketch_learner{"sketch", "least squares on what the render leaves, after each pass",
                                       make_row_learner<SketchLearner>};

void SketchLearner::refine(FitContext& context) {
  const std::vector<ObservedPair> pairs = context.sketch.pairs();
  const std::size_t n = pairs.size();
  std::vector<double> missed(n), gap(n);  // gap[i] is the distance from pair i to the next
  for (std::size_t i = 0; i < n; ++i) {
    const double next = i + 1 < n ? pairs[i + 1].azimuth : pairs[0].azimuth + two_pi;
    gap[i] = next - pairs[i].azimuth;
    missed[i] = std::abs(static_cast<double>(pairs[i].g) - static_cast<double>(context.fit.density(pairs[i].azimuth)));
  }
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < n; ++i) {
    if (gap[i] > refined_gap * context.nodes.blur_rad()) order.push_back(i);
  }
  const auto rank = [&](std::size_t i) { return gap[i] * std::max(missed[i], missed[(i + 1) % n]); };
  std::ranges::sort(order, [&](std::size_t i, std::size_t j) {
    const double of_i = rank(i), of_j = rank(j);
    return of_i != of_j ? of_i > of_j : i < j;
  });
  order.resize(std::min(order.size(), most_refined));
  for (const std::size_t i : order) {
    const auto x = static_cast<float>(pairs[i].azimuth + gap[i] / 2);
    context.sketch.offer(x, context.g(x));
  }
}

bool SketchLearner::refit_due(const FitContext& context, std::uint32_t occupied) const {
  if (!context.has_fit) return true;
  return occupied * 20ull >= bins_at_fit_ * 21ull || context.count >= 2 * count_at_fit_;
}

void SketchLearner::refit(FitContext& context) {
  const std::vector<ObservedPair> pairs = context.sketch.pairs();
  const auto occupied = static_cast<std::uint32_t>(pairs.size());
  if (pairs.empty() || !refit_due(context, occupied)) return;
  const bool restart = context.count >= count_before_restart && context.stop.last_failed();
  const FitSettings settings{context.options.epsilon, context.components, restart};
  context.publish(fit_mixture(pairs, context.nodes.energy(), context.nodes.variation(),
                              context.has_fit ? &context.fit : nullptr, settings)
                      .mixture);
  bins_at_fit_ = occupied;
  count_at_fit_ = context.count;
}

void SketchLearner::begin(FitContext& context) {
  if (context.sketch.occupied() == 0) context.fill_gaps();
  if (context.has_fit) {
    bins_at_fit_ = context.sketch.occupied();
    count_at_fit_ = context.count;
  } else {
    refit(context);
  }
}

void SketchLearner::before_test(FitContext& context) { context.fill_gaps(); }

bool SketchLearner::set_state(std::span<const std::uint64_t> words) {
  if (words.size() != 2 || words[0] > std::numeric_limits<std::uint32_t>::max()) return false;
  bins_at_fit_ = static_cast<std::uint32_t>(words[0]);
  count_at_fit_ = words[1];
  return true;
}

void SketchLearner::learn(FitContext& context) {
  const bool stuck = context.stop.last_failed() && context.count >= count_before_restart;
  if (context.has_fit && (stuck || context.stop.overruled())) refine(context);
  refit(context);
}

}  // namespace tress::inline v0_2::adaptive
