#include "references/learners/eager_learner.h"

#include <vector>

#include "references/learners/own_draw.h"

namespace tress::inline v0_2::adaptive {

void EagerLearner::begin(FitContext& context) {
  SketchLearner::begin(context);
  std::vector<ObservedPair> drawn;
  while (context.stop.verdict() == StopTest::Verdict::undecided) {
    drawn.clear();
    while (context.stop.scores() < context.options.scores_per_test()) drawn.push_back(draw_own(context));
    context.test();
    if (context.stop.verdict() != StopTest::Verdict::undecided) return;
    for (const ObservedPair& pair : drawn) context.sketch.offer(pair.azimuth, pair.g);
    context.fill_gaps();
    SketchLearner::learn(context);
  }
}

}  // namespace tress::inline v0_2::adaptive
