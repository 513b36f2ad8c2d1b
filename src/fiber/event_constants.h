// What every model does with FiberEvent: the known direction into range, and constants of its own beside it.
#pragma once

#include <algorithm>
#include <new>
#include <numbers>
#include <type_traits>

#include "tress/adaptive/mixture.h"
#include "tress/fiber/fiber_model.h"

namespace tress::fiber {

/// theta into [-pi/2, pi/2], phi into [-pi, pi), radians.
inline FiberDirection clamped(const FiberDirection& w) {
  constexpr float half_pi = 0.5f * std::numbers::pi_v<float>;
  return {std::clamp(w.theta, -half_pi, half_pi), adaptive::wrap_angle(w.phi)};
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
