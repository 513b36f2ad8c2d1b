#include "learner/table_learner.h"

#include <utility>

#include "knots/fit_knots.h"

namespace tress::adaptive {

void TableLearner::begin(Lesson& lesson) {
  KnotFit fit = fit_knots(lesson.nodes, lesson.options.epsilon);
  lesson.g_evaluations += fit.evaluations;
  lesson.count += fit.evaluations;
  lesson.close(std::move(fit.table), fit.objective);
}

}  // namespace tress::adaptive
