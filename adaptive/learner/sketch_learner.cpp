#include "learner/sketch_learner.h"

#include <vector>

#include "learner/fit_mixture.h"

namespace tress::adaptive {
namespace {

constexpr std::uint64_t count_before_restart = 64;

}  // namespace

void SketchLearner::cover(Lesson& lesson) {
  for (const float x : coverage_azimuths(lesson.sketch.pairs(), lesson.nodes.blur_rad())) {
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
  if (lesson.sketch.occupied() == 0) cover(lesson);
  if (lesson.has_fit) {
    bins_at_fit_ = lesson.sketch.occupied();
    count_at_fit_ = lesson.count;
  } else {
    refit(lesson);
  }
}

void SketchLearner::before_test(Lesson& lesson) { cover(lesson); }
void SketchLearner::learn(Lesson& lesson) { refit(lesson); }

void EagerLearner::begin(Lesson& lesson) {
  SketchLearner::begin(lesson);
  std::vector<ObservedPair> drawn;
  while (lesson.stop.verdict() == StopTest::Verdict::undecided) {
    drawn.clear();
    while (lesson.stop.scores() < lesson.options.scores_per_test()) drawn.push_back(lesson.draw_own());
    lesson.stop.run(lesson.options);
    if (lesson.stop.verdict() != StopTest::Verdict::undecided) return;
    for (const ObservedPair& pair : drawn) lesson.sketch.offer(pair.azimuth, pair.g);
    cover(lesson);
    refit(lesson);
  }
}

}  // namespace tress::adaptive
