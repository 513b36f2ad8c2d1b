// The rival without mixtures: a knot table, made when the row is born (ESTIMATOR.md, E7).
#pragma once

#include <cstddef>

#include "learner/row_learner.h"

namespace tress::adaptive {

/// begin() fits and closes the row: nothing that a render brings could teach it more.
class TableLearner final : public RowLearner {
 public:
  void begin(Lesson& lesson) override;
  void learn(Lesson&) override {}
  std::size_t bytes() const override { return sizeof(*this); }
};

}  // namespace tress::adaptive
