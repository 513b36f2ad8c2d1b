// The paper's appendix 9.1, "real time adaptive importance sampling": as printed, and the nearest rule that converges.
#pragma once

#include "references/learners/online.h"

namespace tress::inline v0_2::adaptive {

/// As printed, one reading of it line by line (ESTIMATOR.md, E6). A reference: it does not converge.
class LiteralAppendixLearner final : public RowLearner {
 public:
  void begin(FitContext& context) override;
  void learn(FitContext& context) override;
  std::optional<std::vector<std::uint64_t>> state() const override;
  bool set_state(std::span<const std::uint64_t> words) override;
  std::size_t bytes() const override { return sizeof(*this); }

 private:
  void take_one(FitContext& context);

  Vector entry_;  ///< of the table: the average of all that were made
  std::uint64_t entries_ = 1;
};

/// The nearest rule that converges. The optimisation "has a particularly easy solution when M = 1": of all parameters
/// that meet the sample, those nearest to the entry (Kaczmarz 1937; normalised least mean squares), for residuals of
/// either sign; and entries are averaged.
class AppendixLearner final : public RowLearner {
 public:
  void begin(FitContext& context) override;
  void learn(FitContext& context) override;
  std::optional<std::vector<std::uint64_t>> state() const override;
  bool set_state(std::span<const std::uint64_t> words) override;
  std::size_t bytes() const override { return sizeof(*this); }

 private:
  void take_one(const WeightedDraw& draw, double energy);

  Vector entry_, average_;
  std::uint64_t entries_ = 0;
};

}  // namespace tress::inline v0_2::adaptive
