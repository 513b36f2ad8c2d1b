// The error of a fit by a bound instead of draws (ESTIMATOR.md, E3).
#pragma once

#include <span>

#include "tress/adaptive/mixture.h"
#include "tress/adaptive/traced_nodes.h"

namespace tress::inline v0_2::adaptive {

/// Relative squared L2 error of a fit. Finite, >= 0.
struct KnownError {
  double seen = 0;  ///< against g as interpolated
  double most = 0;  ///< upper bound, whatever the interpolation misses
};

/// Bounds the error of `fit`. `grid`: g of `nodes` at equal steps from -pi on, at least 6/blur of them. Between the
/// steps g is interpolated; the error of that is bounded, because g is a sum of Gaussians of known blur and mass. The
/// fit is known everywhere, and is compared at steps of at most half its narrowest scale. Any thread.
KnownError known_error(const Mixture& fit, const TracedNodes& nodes, std::span<const float> grid);

}  // namespace tress::inline v0_2::adaptive
