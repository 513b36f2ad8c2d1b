// Few shapes for fibers whose shape varies: a host adds them ahead, and chooses among them at the hit.
#pragma once

#include <array>
#include <vector>

#include "tress/fiber/parameters.h"

namespace tress::inline v0_2::fiber {

/// Steps of rounded_shape(), from 0: eccentricity; roughness and tilt in radians; radius of the medulla, and
/// asymmetries; wetness.
struct ShapeSteps {
  static constexpr double eccentricity = 0.01, roughness = 0x1.1df46a2529d39p-6, tilt = roughness / 2, medulla = 0.05,
                          wetness = 0.25;
};

/// Rounds the numbers that are part of a row's slice to the step below or above, so that their means over u, uniform
/// in [0, 1)^3 (eccentricity, roughness, others), are the given ones; a step out of a parameter's range becomes the end
/// of that range, so that the mean of a roughness below 1 degree grows. All other members are kept. Numbers are
/// clamped, NaN counts as the least. Any thread.
FiberParameters rounded_shape(FiberParameters fiber, const std::array<float, 3>& u);

/// All that rounded_shape() returns for fibers between two, number by number, in ascending order: the product of the
/// steps of the eccentricity, the roughness and the tilt. The first fiber gives what is not rounded, and medulla,
/// cortex and wetness, which are rounded to the nearest step. Any thread.
std::vector<FiberParameters> rounded_shapes(const FiberParameters& least, const FiberParameters& most);

}  // namespace tress::inline v0_2::fiber
