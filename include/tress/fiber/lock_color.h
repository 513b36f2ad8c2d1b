// The absorption that gives a lock of hair the color that was asked for.
#pragma once

#include <glm/vec3.hpp>

#include "tress/fiber/parameters.h"

namespace tress::fiber {

/// sigma_a, per major semi-axis, with which a lock of these fibers shows `color` in even light: parallel fibers, turned
/// at random about their axes, in a slab ten mean free paths deep, under a radiance of 1 from everywhere. Reads eta,
/// eccentricity, roughness and tilt of `fiber`; a medulla, gains and widths of lobes are not looked at.
///
/// A fit to paths of light through such locks (bench/references/lock_ways.h): off by at most 0.02 for colors from 0.05
/// to 0.95, eta 1.35 to 1.8 and tilts to 8 degrees; parameters beyond are taken for the nearest of these, colors for
/// the nearest in [0.001, 0.999]. A color that is darker than the surface reflects by itself cannot be had: the
/// absorption is then that of a lock which is nearly as dark as it can be. Falls with the color; pure; any thread.
glm::vec3 sigma_a_of_lock(const glm::vec3& color, const FiberParameters& fiber);

}  // namespace tress::fiber
