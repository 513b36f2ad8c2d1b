// The number pi and its multiples.
#pragma once

#include <numbers>

namespace tress::inline v0_2 {

inline constexpr double pi = std::numbers::pi, two_pi = 2 * pi;
inline constexpr double degree = pi / 180;  ///< radians
/// The same numbers in single precision.
inline constexpr float pi_f = std::numbers::pi_v<float>, two_pi_f = 2 * pi_f;
inline constexpr float inverse_two_pi_f = 0.5f * std::numbers::inv_pi_v<float>;

}  // namespace tress::inline v0_2
