// The mean directions of a fitted ribbon.
#pragma once

#include <array>

#include "fit/ribbon_layer.h"

namespace tress::adaptive {

/// Of exits whose weights add up to count: RibbonLight::harmonics.
std::array<double, 4> mean_harmonics(const RibbonLight& light);

/// Tilts the densities by e^(sum_j lambda_j harmonic_j), so that the mean directions are those of the exits: the
/// prior and the straight lines between knots would widen every lobe a little to the same side, and with many
/// scatterings that shows as brightness. Newton's method; as they were where there is no such tilt.
void match_moments(const RibbonLight& light, MainLayer& main, BroadLayer& broad);

}  // namespace tress::adaptive
