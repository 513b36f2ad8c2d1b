// The ways of light through a lock of clear fibers, from which follows the color that the lock shows in even light,
// whatever its pigment.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tress/fiber/parameters.h"

namespace tress::references {

/// A lock: parallel fibers, their major axes turned at random, fill a slab between two planes along them, `depth` mean
/// free paths of light across the fibers deep. Ten is what the middle of `straight.hair` shows.
struct LockRequest {
  double depth = 10;
  double widest_theta = 0.7853982;  ///< the camera's inclinations to the fibers are within it: sines uniform; radians
  /// Likewise the azimuths of the camera to the normal of the slab: a lock that is round is seen so; radians.
  double widest_azimuth = 0;
  std::uint64_t paths = 16'000;
  std::uint64_t seed = 0;
};

/// From where a color is meant to be seen, as the ranges of a LockRequest: 45 degrees either way along fibers whose
/// scales are tilted. Light keeps its inclination in fibers without tilt, so that each has a color of its own; theirs
/// is the one seen as the middle of `straight.hair` is, within 15 degrees along the fibers and 40 across. In between,
/// up to a tilt of 1.5 degrees, the ranges change in proportion. The other fields are as `request` has them.
LockRequest seen_as_color(const fiber::FiberParameters& fiber, LockRequest request);

/// Of each path from the camera into the slab how far it went inside fibers before it left the slab,
/// major semi-axes. The fibers are RoughFiber, sigma_a 0 and without a medulla; at each, one of the parts of a split
/// path is followed by its weight. Paths of more than 4,096 fibers end there. Same request, same ways (oneTBB).
std::vector<float> lock_ways(const fiber::FiberParameters& fiber, const LockRequest& request);

/// Radiance of the lock under an even radiance of 1 from everywhere, with pigment of this absorption per major
/// semi-axis: the mean of exp(-sigma_a way), which holds for all absorptions at once.
double lock_radiance(std::span<const float> ways, double sigma_a);

/// The absorption at which the lock shows `radiance`, in (0, 1); up to 1e3, where only R is left.
double lock_absorption(std::span<const float> ways, double radiance);

}  // namespace tress::references
