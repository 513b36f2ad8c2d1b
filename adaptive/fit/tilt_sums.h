// The sums of ribbon_tilt.cpp, for every instruction set.
#pragma once

#include "fit/ribbon_tilt.h"

namespace tress::adaptive {

/// A knot before it is tilted.
struct TiltedKnot {
  std::array<double, fit_lanes> density, hat;
};
using TiltedKnots = std::array<TiltedKnot, Ribbon::main_knots + Ribbon::broad_knots>;

/// The mass of the tilted knots, the integrals of the harmonics, and the slopes of both by the tilt.
struct TiltSums {
  std::array<double, fit_lanes> mass;
  std::array<std::array<double, fit_lanes>, 4> of_hat, by_knot;
  std::array<std::array<std::array<double, fit_lanes>, 4>, 4> slopes;
};

}  // namespace tress::adaptive
