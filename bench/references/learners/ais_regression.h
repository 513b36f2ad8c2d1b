// The weights a of step IV: a weighted regression of g on the p_d with a >= 0.
#pragma once

#include "references/learners/ais_problem.h"

namespace tress::inline v0_2::adaptive {

/// Gives the range the weights that minimise O, b and all others kept: for L2 exactly, a' = argmin over a >= 0 of
/// (g - P^T a)^T W (g - P^T a) by non-negative least squares (the printed (P^t G P)^-1 P^t G g has the shapes
/// transposed, g in the place of W, and no a >= 0). For relative entropy O is taken to second order about f, and the
/// way there is halved until O does not rise. O never rises.
void regress_weights(AisProblem& problem, AisRange range);

}  // namespace tress::inline v0_2::adaptive
