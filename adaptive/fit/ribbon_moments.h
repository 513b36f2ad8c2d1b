// The mean directions of a fitted ribbon.
#pragma once

#include "fit/ribbon_layer.h"

namespace tress::adaptive {

/// Tilts the densities by e^(sum_j lambda_j harmonic_j), so that the mean directions are those of the exits: the
/// prior and the straight lines between knots would widen every lobe a little to the same side, and with many
/// scatterings that shows as brightness. Newton's method; as they were where there is no such tilt.
void match_moments(const RibbonLight& light, MainLayer& main, BroadLayer& broad);

}  // namespace tress::adaptive
