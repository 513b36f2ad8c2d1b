// Early stopping of the paper's fit (section 5.4): is any further improvement of the objective unlikely?
#pragma once

#include <cstddef>
#include <span>

#include "references/learners/ais_settings.h"

namespace tress::inline v0_2::adaptive {

/// Estimate of the chance of a false positive at the last of x_t = log(o_t), the log relative objectives, oldest first:
/// p_t = 1 - Phi(sqrt k (S_k/k - nu_l)/sigma) + Phi(sqrt k (S_k/k - nu_h)/sigma), from the blocks of k changes
/// y_t = x_t - x_(t-1) that there are (fewer than three at first: what would condition on them is left out).
/// `printed`: mu_l = log(1 + eps) as mu_h, and division by sigma^2: it is 1 always. `mended`: log(1 - eps), sigma.
/// 1 where there is less than one block.
double ais_p_value(std::span<const double> x, std::size_t k, double epsilon, AisStop form);

/// p_T, the product over t = k, 2k, .. T. Not a p-value: its level is 5.6 to 51 % where alpha is 1 %.
double ais_p_product(std::span<const double> x, std::size_t k, double epsilon, AisStop form);

}  // namespace tress::inline v0_2::adaptive
