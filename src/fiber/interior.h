// How light crosses a fiber whose medulla or cortex scatters or absorbs it.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "fiber/traced_parts.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::fiber {

/// A line through the cross-section: the point is (x, y/e); the direction is a unit vector in three dimensions.
struct InnerRay {
  glm::vec2 point;
  glm::vec3 direction;
};

/// The way of light from one hit on the surface to the next.
struct InnerWay {
  float cortex = 0;  ///< major semi-axes
  float kept = 1;    ///< share of the light that the medulla did not absorb
  float along = 0;   ///< way along the axis, towards the tip, major semi-axes
};

/// Moves the ray from a place on the surface, where it heads inwards, to the next hit. In the cortex and in the core it
/// makes free flights between scatterings, with exact distances. Light is absorbed by the medulla along its flights
/// there, and scattered by Henyey and Greenstein's phase function. On return the ray is at the surface, still heading
/// outwards.
InnerWay cross_interior(const TracedParts& parts, float eccentricity, InnerRay& ray, RandomStream& random);

}  // namespace tress::inline v0_2::fiber
