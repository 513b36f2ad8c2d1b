// The alternative to mixtures: a knot table, made when the row is created (ESTIMATOR.md, E7).
#pragma once

#include <cstddef>

#include "fit/row_learner.h"

namespace tress::adaptive {

/// begin() fits and closes the row, because no path of a render could improve it.
class KnotLearner final : public RowLearner {
 public:
  void begin(FitContext& context) override;
  void learn(FitContext&) override {}
  std::optional<std::vector<std::uint64_t>> state() const override { return std::vector<std::uint64_t>{}; }
  bool set_state(std::span<const std::uint64_t> words) override { return words.empty(); }
  std::size_t bytes() const override { return sizeof(*this); }
};

}  // namespace tress::adaptive
