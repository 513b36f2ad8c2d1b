// The angle of a vector without libm and without branches, for one vector or for four in lanes.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "base/float4.h"

namespace tress::inline v0_2 {

/// Returns atan2(y, x) of finite lanes, in [-pi, pi], with an error below 3e-7; 0 where both are 0. The series is in
/// the ratio of the legs, or, where that exceeds tan(pi/8), in the ratio after a turn by pi/4 (Cephes, atanf).
inline Float4 angle_of(Float4 y, Float4 x) {
  const Float4 ax = abs4(x), ay = abs4(y), longer = max4(ax, ay), shorter = min4(ax, ay);
  const Int4 turned = shorter > 0.414213562f * longer;
  const Float4 above = turned ? shorter - longer : shorter, below = turned ? shorter + longer : longer;
  const Float4 t = above / max4(below, splat(1e-37f)), z = t * t;
  const Float4 p = (-3.33329491539e-1f + z * 1.99777106478e-1f) + z * z * (-1.38776856032e-1f + z * 8.05374449538e-2f);
  Float4 angle = (turned ? splat(0.785398163f) : splat(0)) + (t + t * z * p);
  angle = ay > ax ? 1.57079633f - angle : angle;
  angle = x < 0.0f ? 3.14159265f - angle : angle;
  return std::bit_cast<Float4>(std::bit_cast<Int4>(angle) |
                               (std::bit_cast<Int4>(y) & static_cast<std::int32_t>(0x80000000)));
}
inline float angle_of(float y, float x) { return angle_of(splat(y), splat(x))[0]; }

}  // namespace tress::inline v0_2
