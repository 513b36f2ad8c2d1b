// The inverse of the standard normal distribution function.
#pragma once

namespace tress::inline v0_2 {

/// Uses Giles 2012 in single precision; finite for u in [0, 1].
float normal_quantile(float u);

}  // namespace tress::inline v0_2
