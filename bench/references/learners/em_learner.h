// Stepwise EM (Cappe and Moulines 2009) on the mixture of circular skew logistics, with samples weighted by g/q.
#pragma once

#include <vector>

#include "references/learners/online.h"

namespace tress::inline v0_2::adaptive {

/// ESTIMATOR.md, E6. D is fixed. The family has no sufficient statistics of few numbers, so those kept are, per
/// component and bin of the circle, the running mean of weight times responsibility: additive, and enough for any
/// M step on azimuths rounded to a bin (a sixth of the blur or less).
class EmLearner final : public RowLearner {
 public:
  void begin(FitContext& context) override;
  void learn(FitContext& context) override;
  std::optional<std::vector<std::uint64_t>> state() const override;
  bool set_state(std::span<const std::uint64_t> words) override;
  std::size_t bytes() const override;

 private:
  /// E step on draws, and statistics towards theirs by `step`.
  void expect(const std::vector<WeightedDraw>& draws, double step);
  /// M step: weights in closed form; mode and scales by Newton steps on the expected log likelihood.
  void maximise(double energy);
  void maximise_shape(Eigen::Index component, double mass);

  int bins_ = 0;
  std::uint64_t batches_ = 0;
  Vector parameters_;
  std::vector<float> statistics_;  ///< (D + 1) x bins, the uniform part last
};

}  // namespace tress::inline v0_2::adaptive
