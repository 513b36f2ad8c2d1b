// How far a fit is from its target, by a bound instead of draws (ESTIMATOR.md, E3).
#pragma once

#include <span>

#include "tress/adaptive/mixture.h"
#include "tress/adaptive/traced_nodes.h"

namespace tress::adaptive {

/// Relative squared L2 error of a fit. Finite, >= 0.
struct KnownError {
  double seen = 0;  ///< from g as it is interpolated
  double most = 0;  ///< whatever the interpolation hides
};

/// Of `fit`, from `grid`, g of `nodes` at equal steps from -pi on, at least 6/blur of them. Between the steps g is
/// known by interpolation to within what a sum of Gaussians of that blur and mass can hide from them; the fit is known
/// everywhere, and compared no further apart than half of its narrowest scale. Any thread.
KnownError known_error(const Mixture& fit, const TracedNodes& nodes, std::span<const float> grid);

}  // namespace tress::adaptive
