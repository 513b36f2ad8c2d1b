// The paper's adaptive importance sampling behind the table: run to the end when a row opens.
#pragma once

#include "fit/row_learner.h"

namespace tress::inline v0_2::adaptive {

/// Fits by fit_ais with its default settings but D, which is FitContext::components, and the threshold, a quarter of
/// Options::epsilon, as for ours: the row's own test has far fewer draws. A fit that fails that test is made anew from
/// another stream, a few times, and the better one kept; a row that has none is refused in the end and answered by g.
class AisLearner final : public RowLearner {
 public:
  void begin(FitContext& context) override;
  void learn(FitContext&) override {}
  std::optional<std::vector<std::uint64_t>> state() const override { return std::vector<std::uint64_t>{}; }
  bool set_state(std::span<const std::uint64_t> words) override { return words.empty(); }
  std::size_t bytes() const override { return sizeof(*this); }
};

}  // namespace tress::inline v0_2::adaptive
