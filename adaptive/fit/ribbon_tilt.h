// Fits the mean directions of ribbons.
#pragma once

#include "fit/ribbon_lanes.h"

namespace tress::inline v0_2::adaptive {

constexpr std::size_t tilt_harmonics = RowExits::harmonics;

/// The contribution of a knot of a part to the means of cos x, sin x, cos 2x, sin 2x and so on (RowExits::orders), and
/// these values at the knot itself.
struct KnotHarmonics {
  std::array<std::array<double, fit_lanes>, tilt_harmonics> at, of_hat;
};
struct RowHarmonics {
  std::array<KnotHarmonics, Ribbon::main_knots + Ribbon::broad_knots> knots;  ///< of the main layer, then the broad
};
void place_harmonics(const RibbonLanes& lanes, RowHarmonics& out);

/// Mean directions, by problem.
using MeanDirections = std::array<std::array<double, fit_lanes>, tilt_harmonics>;
MeanDirections mean_directions(const RibbonLanes& lanes, const RowHarmonics& harmonics);

/// Tilts the densities by e^(sum_j lambda_j harmonic_j), so that the mean directions are these. Without it, the prior
/// and the straight lines between knots would widen every lobe a little to the same side, which after many scatterings
/// changes the brightness. Uses Newton's method; leaves the densities as they were if no such tilt exists.
void match_directions(RibbonLanes& lanes, const RowHarmonics& harmonics, const MeanDirections& directions);

/// A knot before it is tilted.
struct TiltedKnot {
  std::array<double, fit_lanes> density, hat;
};
using TiltedKnots = std::array<TiltedKnot, Ribbon::main_knots + Ribbon::broad_knots>;

/// The mass of the tilted knots, the integrals of the harmonics, and the slopes of both by the tilt.
struct TiltSums {
  std::array<double, fit_lanes> mass;
  std::array<std::array<double, fit_lanes>, tilt_harmonics> of_hat, by_knot;
  std::array<std::array<std::array<double, fit_lanes>, tilt_harmonics>, tilt_harmonics> slopes;
};

}  // namespace tress::inline v0_2::adaptive
