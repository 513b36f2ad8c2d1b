#include "references/learners/ais_learner.h"

#include <limits>

#include "references/learners/ais.h"
#include "references/learners/own_draw.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr int most_fits = 4;

// A fit of its own stream; g is counted by the context.
AisFit fit_of(FitContext& context) {
  AisSettings settings;
  settings.components = context.components;
  settings.threshold = context.options.epsilon / 4;
  const AisTarget target{[&context](float x) { return static_cast<double>(context.g(x)); }, context.nodes.energy(),
                         context.nodes.variation()};
  return fit_ais(target, RandomStream(context.random.next_bits()), settings);
}

}  // namespace

void AisLearner::begin(FitContext& context) {
  double best = std::numeric_limits<double>::infinity();
  int fits = 0;
  const auto fit_anew = [&] {
    const AisFit fit = fit_of(context);
    if (++fits == 1 || fit.objective < best) {
      context.publish(fit.mixture);
      best = fit.objective;
    }
  };
  if (!context.has_fit) fit_anew();
  while (context.stop.verdict() == StopTest::Verdict::undecided) {
    while (context.stop.scores() < context.options.scores_per_test()) draw_own(context);
    context.test();
    const bool open = context.stop.verdict() == StopTest::Verdict::undecided;
    if (open && context.stop.last_failed() && fits < most_fits) fit_anew();
  }
}

}  // namespace tress::inline v0_2::adaptive
