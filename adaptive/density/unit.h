// Numbers of a caller, brought into [0, 1].
#pragma once

#include <algorithm>

namespace tress::inline v0_2::adaptive {

/// Clamps into [0, 1]; NaN becomes 0.
inline float unit(float x) { return x > 0 ? std::min(x, 1.0f) : 0; }

}  // namespace tress::inline v0_2::adaptive
