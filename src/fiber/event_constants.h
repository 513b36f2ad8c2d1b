// The part of FiberEvent that all models share: clamps the known direction, and keeps a model's constants.
#pragma once

#include <algorithm>
#include <limits>
#include <new>
#include <numbers>
#include <type_traits>

#include "tress/adaptive/mixture.h"
#include "tress/fiber/fiber_model.h"

namespace tress::inline v0_2::fiber {

/// Clamps theta into [-pi/2, pi/2] and wraps phi into [-pi, pi), radians. NaN becomes 0, as does an infinite phi.
inline FiberDirection clamped(const FiberDirection& w) {
  constexpr float half_pi = 0.5f * std::numbers::pi_v<float>, most = std::numeric_limits<float>::max();
  const float theta = w.theta == w.theta ? w.theta : 0.0f;
  const float phi = w.phi >= -most && w.phi <= most ? w.phi : 0.0f;
  return {std::clamp(theta, -half_pi, half_pi), adaptive::wrap_angle(phi)};
}

/// The place for a model's constants in an event: new (place_of<Constants>(event)) Constants{...}.
template <class Constants>
void* place_of(FiberEvent& event) {
  static_assert(sizeof(Constants) <= sizeof(EventConstants) && alignof(Constants) <= alignof(EventConstants));
  static_assert(std::is_trivially_copyable_v<Constants>);
  return event.constants.bytes_.data();
}

/// The constants in the event; the type must be the one that was put there.
template <class Constants>
const Constants& constants_in(const FiberEvent& event) {
  return *std::launder(reinterpret_cast<const Constants*>(event.constants.bytes_.data()));
}

}  // namespace tress::inline v0_2::fiber
