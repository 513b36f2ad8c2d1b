#include "fit/knot_learner.h"

#include <utility>

#include "fit/fit_knots.h"

namespace tress::adaptive {

void KnotLearner::begin(FitContext& context) {
  KnotFit fit = fit_knots(context.nodes, context.options.epsilon);
  context.g_evaluations += fit.evaluations;
  context.count += fit.evaluations;
  context.close(std::move(fit.table), fit.objective);
}

}  // namespace tress::adaptive
