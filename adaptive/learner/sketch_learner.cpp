#include "learner/sketch_learner.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "learner/fit_mixture.h"

namespace tress::adaptive {
namespace {

constexpr std::uint64_t count_before_restart = 64;
constexpr std::size_t most_refined = 12;  // azimuths after a failed test
constexpr double refined_gap = 0.5;       // in blurs: closer pairs say the same

}  // namespace

void SketchLearner::refine(Lesson& lesson) {
  constexpr double two_pi = 2 * std::numbers::pi;
  const std::vector<ObservedPair> pairs = lesson.sketch.pairs();
  const std::size_t n = pairs.size();
  std::vector<double> missed(n), gap(n);  // gap[i]: from pair i to the next
  for (std::size_t i = 0; i < n; ++i) {
    const double next = i + 1 < n ? pairs[i + 1].azimuth : pairs[0].azimuth + two_pi;
    gap[i] = next - pairs[i].azimuth;
    missed[i] = std::abs(static_cast<double>(pairs[i].g) - static_cast<double>(lesson.fit.density(pairs[i].azimuth)));
  }
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < n; ++i) {
    if (gap[i] > refined_gap * lesson.nodes.blur_rad()) order.push_back(i);
  }
  const auto rank = [&](std::size_t i) { return gap[i] * std::max(missed[i], missed[(i + 1) % n]); };
  std::ranges::sort(order, [&](std::size_t i, std::size_t j) {
    const double of_i = rank(i), of_j = rank(j);
    return of_i != of_j ? of_i > of_j : i < j;
  });
  order.resize(std::min(order.size(), most_refined));
  for (const std::size_t i : order) {
    const auto x = static_cast<float>(pairs[i].azimuth + gap[i] / 2);
    lesson.sketch.offer(x, lesson.g(x));
  }
}

bool SketchLearner::refit_due(const Lesson& lesson, std::uint32_t occupied) const {
  if (!lesson.has_fit) return true;
  return occupied * 20ull >= bins_at_fit_ * 21ull || lesson.count >= 2 * count_at_fit_;
}

void SketchLearner::refit(Lesson& lesson) {
  const std::vector<ObservedPair> pairs = lesson.sketch.pairs();
  const auto occupied = static_cast<std::uint32_t>(pairs.size());
  if (pairs.empty() || !refit_due(lesson, occupied)) return;
  const bool restart = lesson.count >= count_before_restart && lesson.stop.last_failed();
  const FitSettings settings{lesson.options.epsilon, lesson.components, restart};
  lesson.publish(fit_mixture(pairs, lesson.nodes.energy(), lesson.nodes.variation(),
                             lesson.has_fit ? &lesson.fit : nullptr, settings)
                     .mixture);
  bins_at_fit_ = occupied;
  count_at_fit_ = lesson.count;
}

void SketchLearner::begin(Lesson& lesson) {
  if (lesson.sketch.occupied() == 0) lesson.cover();
  if (lesson.has_fit) {
    bins_at_fit_ = lesson.sketch.occupied();
    count_at_fit_ = lesson.count;
  } else {
    refit(lesson);
  }
}

void SketchLearner::before_test(Lesson& lesson) { lesson.cover(); }

void SketchLearner::learn(Lesson& lesson) {
  const bool stuck = lesson.stop.last_failed() && lesson.count >= count_before_restart;
  if (lesson.has_fit && (stuck || lesson.stop.overruled())) refine(lesson);
  refit(lesson);
}

void EagerLearner::begin(Lesson& lesson) {
  SketchLearner::begin(lesson);
  std::vector<ObservedPair> drawn;
  while (lesson.stop.verdict() == StopTest::Verdict::undecided) {
    drawn.clear();
    while (lesson.stop.scores() < lesson.options.scores_per_test()) drawn.push_back(lesson.draw_own());
    lesson.test();
    if (lesson.stop.verdict() != StopTest::Verdict::undecided) return;
    for (const ObservedPair& pair : drawn) lesson.sketch.offer(pair.azimuth, pair.g);
    lesson.cover();
    SketchLearner::learn(lesson);
  }
}

}  // namespace tress::adaptive
