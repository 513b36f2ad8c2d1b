// The paper's appendix 9.1, "real time adaptive importance sampling": as printed, and the nearest rule that converges.
#pragma once

#include "references/learners/online.h"

namespace tress::inline v0_2::adaptive {

/// As printed, one reading of it line by line. A reference: it does not converge.
///   "a small, threshold parameter" epsilon; tau in the test: tau = epsilon.
///   phi is sampled from the mixture, w(phi) = N/sum a p: from the entry as it stands, with the uniform share.
///   2, if (N - sum a_d p_d) w >= tau: one-sided as printed; a fit that is too high is never lowered.
///   i: the component to which the sample most likely belongs.
///   3, b'_i in {b: d/db p_i(phi; b) = 0}: its mode at phi; its scales stay, since none makes that derivative 0 there.
///   4, a'_i = (N - sum a_d p_d(phi; b'_d)) / p(phi; b'_i): the sum is over all d with the old a.
///   "averaging every new entry": a_i and mu_i move by 1/n at the n-th entry, the mode round the circle.
///   6, the objective N - sum a' p(b'): not used; it is 0 by construction, so every row would converge.
/// Where the fit is right, residual and new weight are both 0, and the average pulls the old weight towards 0: its
/// fixed points are not those of least squares.
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
