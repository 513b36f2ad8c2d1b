// A fiber's core: how it absorbs and scatters light that crosses it.
#pragma once

#include <array>
#include <compare>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "tress/base/random.h"
#include "tress/fiber/parameters.h"

namespace tress::inline v0_2::fiber {

/// The medulla of FiberParameters. All members are 0 without a medulla, so that such fibers are equal.
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

/// Returns the fiber for models that have no medulla.
inline FiberParameters without_medulla(FiberParameters fiber) {
  Medulla{}.give_to(fiber);
  return fiber;
}

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

/// Moves the ray from a place on the surface, where it heads inwards, to the next hit. In the core it makes free
/// flights between scatterings, with exact distances. Light is absorbed along its flights and scattered by Henyey and
/// Greenstein's phase function. On return the ray is at the surface, still heading outwards.
InnerWay cross_with_medulla(const Medulla& medulla, float eccentricity, InnerRay& ray, RandomStream& random);

}  // namespace tress::inline v0_2::fiber
