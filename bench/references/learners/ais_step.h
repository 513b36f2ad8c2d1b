// The step of the shape parameters b in step IV: Newton's, or down the gradient.
#pragma once

#include <cstddef>
#include <vector>

#include "references/learners/ais_problem.h"

namespace tress::inline v0_2::adaptive {

/// Bounds B of b: mu in [-pi, pi) (it wraps, or stops at the ends of the line), scales in [0.004, 0.5] as mixture.h.
/// Keeps what one step has taught the next: the damping of Newton's steps and the length of the gradient's, for each
/// range's first component apart from the complete step's.
class AisStepper {
 public:
  AisStepper(AisStep kind, std::size_t components);

  /// One step of the b of the range, a kept. True if O fell; else nothing has changed.
  bool step(AisProblem& problem, AisRange range);

 private:
  bool newton(AisProblem& problem, AisRange range, double& damping) const;
  bool gradient(AisProblem& problem, AisRange range, double& length) const;

  AisStep kind_;
  std::vector<double> memory_;
};

}  // namespace tress::inline v0_2::adaptive
