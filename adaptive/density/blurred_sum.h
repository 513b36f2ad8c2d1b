// The sum that g of a traced node is, for the widest instruction set that the machine has.
#pragma once

#include <cstddef>

namespace tress::adaptive {

/// Rays are summed in whole groups of at most this many: both arrays must be readable that far past `count`, less one.
constexpr std::size_t blurred_sum_padding = 15;

/// sum_j weight_j exp(-(azimuth_j - x)^2 precision), precision = 1/(2 sigma^2), over at least the first `count` rays:
/// up to blurred_sum_padding more are summed too. Exponents below -87 count as that.
/// Relative error below 1e-6 for weights of one sign. Any thread; the same bits on one machine.
float blurred_sum(const float* azimuth, const float* weight, std::size_t count, float x, float precision);

}  // namespace tress::adaptive
