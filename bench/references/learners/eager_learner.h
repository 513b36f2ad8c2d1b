// The shipped method, run to the end when a row opens: cover, fit, draw as many of its own azimuths as a test needs,
// test, repeat. It is the fair alternative wherever g is in closed form: the paths of a render then add nothing that
// evaluating g does not.
#pragma once

#include "fit/sketch_learner.h"

namespace tress::inline v0_2::adaptive {

class EagerLearner final : public SketchLearner {
 public:
  void begin(FitContext& context) override;
  void before_test(FitContext&) override {}
  void learn(FitContext&) override {}
};

}  // namespace tress::inline v0_2::adaptive
