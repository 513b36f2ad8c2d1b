#include "learner/ais_learner.h"

#include <limits>

#include "learner/ais.h"

namespace tress::adaptive {
namespace {

constexpr int most_fits = 4;

// A fit of its own stream; g is counted by the lesson.
AisFit fit_of(Lesson& lesson) {
  AisSettings settings;
  settings.components = lesson.components;
  settings.threshold = lesson.options.epsilon / 4;
  const AisTarget target{[&lesson](float x) { return static_cast<double>(lesson.g(x)); }, lesson.nodes.energy(),
                         lesson.nodes.variation()};
  return fit_ais(target, RandomStream(lesson.random.next_bits()), settings);
}

}  // namespace

void AisLearner::begin(Lesson& lesson) {
  double best = std::numeric_limits<double>::infinity();
  int fits = 0;
  const auto fit_anew = [&] {
    const AisFit fit = fit_of(lesson);
    if (++fits == 1 || fit.objective < best) {
      lesson.publish(fit.mixture);
      best = fit.objective;
    }
  };
  if (!lesson.has_fit) fit_anew();
  while (lesson.stop.verdict() == StopTest::Verdict::undecided) {
    while (lesson.stop.scores() < lesson.options.scores_per_test()) lesson.draw_own();
    lesson.test();
    const bool open = lesson.stop.verdict() == StopTest::Verdict::undecided;
    if (open && lesson.stop.last_failed() && fits < most_fits) fit_anew();
  }
}

}  // namespace tress::adaptive
