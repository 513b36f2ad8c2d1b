// One step of the fits of a row's ribbons towards the largest likelihood, for all problems at once.
#pragma once

#include "fit/ribbon_lanes.h"

namespace tress::inline v0_2::adaptive {

/// The strengths of the prior, in exits of equal weight.
struct RibbonPrior {
  float density = 8, mode = 30, scale = 100;
};

/// Moves modes and scales, then densities, by the sums of the segments (add_exits), and scales both layers' densities
/// to mass 1.
void move_layers(RibbonLanes& lanes, const RowSums& sums, const RibbonPrior& prior);

/// Scales the densities of both layers so that their mass is 1.
void scale_to_one(RibbonLanes& lanes);

}  // namespace tress::inline v0_2::adaptive
