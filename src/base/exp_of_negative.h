// Exponential of a non-positive float without branches or calls, so that loops over it vectorise.
#pragma once

#include <bit>
#include <cstdint>

namespace tress::inline v0_2 {

/// exp(x) for x <= 0, relative error below 3e-7; below -87 it returns exp(-87), about 1.6e-38 (never a denormal).
/// Cody-Waite reduction to |r| <= ln 2 / 2, polynomial of degree 6 (truncation r^7/7! <= 1.2e-7).
inline float exp_of_negative(float x) {
  x = x < -87.0f ? -87.0f : x;
  const auto n = static_cast<std::int32_t>(x * 1.44269504f - 0.5f);  // truncation, which for x <= 0 rounds to nearest
  const float k = static_cast<float>(n);
  const float r = (x - k * 0.693359375f) + k * 2.12194440e-4f;
  const float p =
      1.0f +
      r * (1.0f + r * (0.5f + r * (1.66666667e-1f + r * (4.16666667e-2f + r * (8.33333333e-3f + r * 1.38888889e-3f)))));
  return p * std::bit_cast<float>(static_cast<std::uint32_t>(n + 127) << 23);
}

}  // namespace tress::inline v0_2
