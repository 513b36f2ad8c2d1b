// One step of the fit of a ribbon's layer towards the largest likelihood.
#pragma once

#include <array>
#include <cstddef>

#include "fit/fit_ribbon.h"
#include "fit/ribbon_layer.h"

namespace tress::adaptive {

/// Moves modes and scales, then densities, by the sums of the segments (add_exits), of `exits` exits of weight 1.
/// Neither density is scaled to mass 1 by it.
void move_layer(MainLayer& layer, HeightLaw law, const std::array<SegmentSums, Ribbon::main_knots>& sums, double exits,
                const RibbonFitRule& rule);
void move_layer(BroadLayer& layer, HeightLaw law, const std::array<SegmentSums, Ribbon::broad_knots>& sums,
                double exits, const RibbonFitRule& rule);

}  // namespace tress::adaptive
