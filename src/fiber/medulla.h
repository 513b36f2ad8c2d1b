// A fiber's core: what light that goes through it keeps, and where to.
#pragma once

#include <array>
#include <compare>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "tress/base/random.h"
#include "tress/fiber/parameters.h"

namespace tress::fiber {

/// FiberParameters' medulla; all 0 where there is none, so that fibers without one are alike.
struct Medulla {
  float radius = 0, scattering = 0, asymmetry = 0, absorption = 0;

  static Medulla of(const FiberParameters& fiber) {
    if (!(fiber.medulla_radius > 0)) return {};
    return {fiber.medulla_radius, fiber.medulla_scattering, fiber.medulla_asymmetry, fiber.medulla_absorption};
  }
  void give_to(FiberParameters& fiber) const {
    fiber.medulla_radius = radius;
    fiber.medulla_scattering = scattering;
    fiber.medulla_asymmetry = asymmetry;
    fiber.medulla_absorption = absorption;
  }
  bool is_there() const { return radius > 0; }
  std::array<float, 4> values() const { return {radius, scattering, asymmetry, absorption}; }
  friend auto operator<=>(const Medulla&, const Medulla&) = default;
};

/// The fiber as models that know no medulla see it.
inline FiberParameters without_medulla(FiberParameters fiber) {
  Medulla{}.give_to(fiber);
  return fiber;
}

/// A line through the cross-section: the point is (x, y/e), the direction unit and in three dimensions.
struct InnerRay {
  glm::vec2 point;
  glm::vec3 direction;
};

/// Way from one surface to the next.
struct InnerWay {
  float cortex = 0;  ///< major semi-axes
  float kept = 1;    ///< what the medulla has not absorbed
};

/// From a place of the surface, where the ray heads inwards, to the next: free flights between scatterings in the core,
/// exact distances. Light is absorbed along its flights and scattered by Henyey and Greenstein's phase function; the
/// ray is left where it meets the surface, as it heads there.
InnerWay cross_with_medulla(const Medulla& medulla, float eccentricity, InnerRay& ray, RandomStream& random);

}  // namespace tress::fiber
