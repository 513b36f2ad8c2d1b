// What every model does with FiberEvent: the known direction into range, and constants of its own beside it.
#pragma once

#include <algorithm>
#include <limits>
#include <new>
#include <numbers>
#include <type_traits>

#include "tress/adaptive/mixture.h"
#include "tress/fiber/fiber_model.h"

namespace tress::fiber {

/// theta into [-pi/2, pi/2], phi into [-pi, pi), radians. What is not a number is 0, as is a phi of no end.
inline FiberDirection clamped(const FiberDirection& w) {
  constexpr float half_pi = 0.5f * std::numbers::pi_v<float>, most = std::numeric_limits<float>::max();
  const float theta = w.theta == w.theta ? w.theta : 0.0f;
  const float phi = w.phi >= -most && w.phi <= most ? w.phi : 0.0f;
  return {std::clamp(theta, -half_pi, half_pi), adaptive::wrap_angle(phi)};
}

/// Where a model's constants of an event lie: new (place_of<Constants>(event)) Constants{...}.
template <class Constants>
void* place_of(FiberEvent& event) {
  static_assert(sizeof(Constants) <= sizeof(EventConstants) && alignof(Constants) <= alignof(EventConstants));
  static_assert(std::is_trivially_copyable_v<Constants>);
  return event.constants.bytes_.data();
}

/// The constants that were put there, by the same type.
template <class Constants>
const Constants& constants_in(const FiberEvent& event) {
  return *std::launder(reinterpret_cast<const Constants*>(event.constants.bytes_.data()));
}

}  // namespace tress::fiber
