// The default method: Levenberg-Marquardt on the sketch, refitted when the sketch has grown (ESTIMATOR.md, E3 and E6).
#pragma once

#include "fit/row_learner.h"

namespace tress::inline v0_2::adaptive {

/// Learns after each pass, from the pairs of the render and those of the coverage rule.
class SketchLearner : public RowLearner {
 public:
  void begin(FitContext& context) override;
  void before_test(FitContext& context) override;
  void learn(FitContext& context) override;
  std::optional<std::vector<std::uint64_t>> state() const override {
    return std::vector<std::uint64_t>{bins_at_fit_, count_at_fit_};
  }
  bool set_state(std::span<const std::uint64_t> words) override;
  std::size_t bytes() const override { return sizeof(*this); }

 protected:
  /// Evaluates g between the pairs that the fit misses most.
  static void refine(FitContext& context);
  /// Fits anew if the sketch has grown enough since the last fit.
  void refit(FitContext& context);

 private:
  bool refit_due(const FitContext& context, std::uint32_t occupied) const;

  std::uint32_t bins_at_fit_ = 0;
  std::uint64_t count_at_fit_ = 0;
};

}  // namespace tress::inline v0_2::adaptive
