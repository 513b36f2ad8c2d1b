// The sum that gives g of a traced node, for the widest instruction set that the machine has.
#pragma once

#include <cstddef>

namespace tress::inline v0_2::adaptive {

/// Rays are summed in groups of up to 16, so both arrays must be readable this many elements past `count`.
constexpr std::size_t blurred_sum_padding = 15;

/// Returns sum_j weight_j exp(-(azimuth_j - x)^2 precision), precision = 1/(2 sigma^2), over at least the first `count`
/// rays and up to blurred_sum_padding more. Exponents below -87 count as -87. The relative error is below 1e-6 for
/// weights of one sign. Any thread; the same bits on one machine.
float blurred_sum(const float* azimuth, const float* weight, std::size_t count, float x, float precision);

}  // namespace tress::inline v0_2::adaptive
