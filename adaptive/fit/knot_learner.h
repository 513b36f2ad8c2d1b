// The rival without mixtures: a knot table, made when the row is created (ESTIMATOR.md, E7).
#pragma once

#include <cstddef>

#include "fit/row_learner.h"

namespace tress::adaptive {

/// begin() fits and closes the row: nothing that a render brings could teach it more.
class KnotLearner final : public RowLearner {
 public:
  void begin(FitContext& context) override;
  void learn(FitContext&) override {}
  std::size_t bytes() const override { return sizeof(*this); }
};

}  // namespace tress::adaptive
