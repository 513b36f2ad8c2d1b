#include <array>

#include "fit/knot_learner.h"
#include "fit/row_learner.h"
#include "fit/sketch_learner.h"
#include "tress/adaptive/learner.h"

namespace tress::adaptive {

constinit const Learner sketch_learner{"sketch", "least squares on what the render leaves, after each pass",
                                       make_row_learner<SketchLearner>};
constinit const Learner knot_learner{"table", "no mixture: 32 to 128 linear knots, on the first query",
                                     make_row_learner<KnotLearner>, true};

std::span<const Learner* const> shipped_learners() {
  static constexpr std::array all{&sketch_learner, &knot_learner};
  return all;
}

}  // namespace tress::adaptive
