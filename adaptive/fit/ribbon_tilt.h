// The mean directions of fitted ribbons.
#pragma once

#include "fit/ribbon_lanes.h"

namespace tress::adaptive {

/// What a knot of a part adds to the mean of cos x, sin x, cos 2x, sin 2x, and where it stands itself.
struct KnotHarmonics {
  std::array<std::array<double, fit_lanes>, 4> at, of_hat;
};
struct RowHarmonics {
  std::array<KnotHarmonics, Ribbon::main_knots + Ribbon::broad_knots> knots;  ///< of the main layer, then the broad one
};
void place_harmonics(const RibbonLanes& lanes, RowHarmonics& out);

/// Mean directions, by problem.
using MeanDirections = std::array<std::array<double, fit_lanes>, 4>;
MeanDirections mean_directions(const RibbonLanes& lanes, const RowHarmonics& harmonics);

/// Tilts the densities by e^(sum_j lambda_j harmonic_j), so that the mean directions are these: the prior and the
/// straight lines between knots would widen every lobe a little to the same side, and with many scatterings that shows
/// as brightness. Newton's method; as they were where there is no such tilt.
void match_directions(RibbonLanes& lanes, const RowHarmonics& harmonics, const MeanDirections& directions);

}  // namespace tress::adaptive
