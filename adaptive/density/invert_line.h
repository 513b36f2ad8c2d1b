// The inverse CDF of a density that is a straight line.
#pragma once

#include <algorithm>
#include <cmath>

namespace tress::inline v0_2::adaptive {

/// Returns the point of [0, 1] with the share r of the mass below it, under a straight line from density a to density
/// b. This form of the inverse CDF loses no bits where a and b are close. a, b >= 0; r in [0, 1].
inline float invert_line(float a, float b, float r) {
  // a s + (b - a) s^2/2 = r (a + b)/2; the roots are geometric in the squares of the densities.
  const float root = std::sqrt(a * a + r * (b - a) * (b + a));
  const float below = a + root;
  return below > 0 ? std::min(r * (a + b) / below, 1.0f) : r;
}

}  // namespace tress::inline v0_2::adaptive
