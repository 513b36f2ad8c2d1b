// What only traced fibers have: a medulla, a cortex that scatters, and a film of water.
#pragma once

#include <algorithm>
#include <array>
#include <compare>
#include <cstddef>

#include "tress/fiber/parameters.h"

namespace tress::inline v0_2::fiber {

constexpr float eta_of_water = 1.33f;
/// The roughness of the outer surface of a film of water on a fiber with that roughness.
inline float film_roughness(float roughness) { return std::min(roughness, 0.05f); }

/// Members of FiberParameters. Those without an effect are 0, so that such fibers are equal.
struct TracedParts {
  float radius = 0, scattering = 0, asymmetry = 0, absorption = 0;  ///< of the medulla
  float cortex_scattering = 0, cortex_asymmetry = 0;
  float wetness = 0;

  static TracedParts of(const FiberParameters& fiber) {
    TracedParts parts;
    if (fiber.medulla_radius > 0)
      parts = {fiber.medulla_radius, fiber.medulla_scattering, fiber.medulla_asymmetry, fiber.medulla_absorption};
    if (fiber.cortex_scattering > 0) {
      parts.cortex_scattering = fiber.cortex_scattering;
      parts.cortex_asymmetry = fiber.cortex_asymmetry;
    }
    parts.wetness = fiber.wetness;
    return parts;
  }
  void give_to(FiberParameters& fiber) const {
    fiber.medulla_radius = radius;
    fiber.medulla_scattering = scattering;
    fiber.medulla_asymmetry = asymmetry;
    fiber.medulla_absorption = absorption;
    fiber.cortex_scattering = cortex_scattering;
    fiber.cortex_asymmetry = cortex_asymmetry;
    fiber.wetness = wetness;
  }
  /// Whether light inside only goes straight on.
  bool are_plain() const { return !(radius > 0) && !(cortex_scattering > 0); }

  static constexpr std::size_t count = 7;
  std::array<float, count> values() const {
    return {radius, scattering, asymmetry, absorption, cortex_scattering, cortex_asymmetry, wetness};
  }
  static TracedParts from(const float* values) {
    return {values[0], values[1], values[2], values[3], values[4], values[5], values[6]};
  }
  friend auto operator<=>(const TracedParts&, const TracedParts&) = default;
};

/// Returns the fiber for models that have no such parts.
inline FiberParameters without_parts(FiberParameters fiber) {
  TracedParts{}.give_to(fiber);
  return fiber;
}

}  // namespace tress::inline v0_2::fiber
