// Evaluates and samples converged rows: one row, or all rows of a vertex at once. Inlined into callers.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <numbers>

#include "base/float4.h"
#include "base/logarithm.h"
#include "fiber/row_axes.h"
#include "models/elliptical/absorbed_row.h"

namespace tress::inline v0_2::fiber {

/// E/(1 + E)^2 of two components of each of two rows at azimuth x, lanes {a 0, a 1, b 0, b 1}. Times the amplitude it
/// is a component's density. x in [-pi, pi].
inline Float4 logistic_kernels(float x, const AbsorbedRow& a, const AbsorbedRow& b) {
  constexpr float pi = std::numbers::pi_v<float>;
  // The shorter way round the circle, negated, and whether it leads to the left.
  const Float4 offset = x - pairs4(a.mu.data(), b.mu.data());
  const Float4 straight = -abs4(offset), round = -2 * pi - straight;
  const Int4 is_left = (offset < 0.0f) ^ (straight < round);
  const Float4 left = pairs4(a.inverse_left.data(), b.inverse_left.data());
  const Float4 right = pairs4(a.inverse_right.data(), b.inverse_right.data());
  const Float4 e = exp_of_negative(max4(straight, round) * (is_left ? left : right));
  return e / ((1 + e) * (1 + e));
}

/// The components of one line for a mix of the channels.
struct LineMasses {
  Float4 inverse;  ///< 1/s: left side of both, then right side of both
  Float4 side;     ///< s T, T = tanh(pi / 2s), in the same order
  float peak[2];   ///< amplitude in the mix
  float whole[2];  ///< 2 Z
  float share[2];  ///< mass in the mix
  LineMasses(const AbsorbedRow& line, const glm::vec3& mix) {
    constexpr float pi = std::numbers::pi_v<float>;
    inverse = Float4{line.inverse_left[0], line.inverse_left[1], line.inverse_right[0], line.inverse_right[1]};
    const Float4 e = exp_of_negative(-pi * inverse);
    side = (1 - e) / ((1 + e) * inverse);
    for (int d = 0; d < 2; ++d) {
      const glm::vec3& amplitude = line.amplitude[d];
      peak[d] = mix.x * amplitude.x + mix.y * amplitude.y + mix.z * amplitude.z;
      whole[d] = side[d] + side[d + 2];
      share[d] = 0.5f * whole[d] * peak[d];
    }
  }
};

/// Draws from the components of a line; u in [0, sum of their shares). Inverse CDF: ESTIMATOR.md, E1.
inline float sample_components(const AbsorbedRow& line, const LineMasses& of, float u) {
  constexpr float pi = std::numbers::pi_v<float>;
  const bool second = u >= of.share[0];
  const float left = second ? of.side[1] : of.side[0], all = second ? of.whole[1] : of.whole[0];
  const float from = second ? u - of.share[0] : u;
  const float at = std::min(2 * from / (second ? of.peak[1] : of.peak[0]), all) - left;  // in masses s T, from the mode
  const bool is_left = at < 0;
  const float inverse_left = second ? of.inverse[1] : of.inverse[0];
  const float inverse_right = second ? of.inverse[3] : of.inverse[2];
  const float inverse_s = is_left ? inverse_left : inverse_right;
  const float t = std::min(std::abs(at) * inverse_s, 0.99999994f);
  const float x = std::min(natural_log((1 + t) / (1 - t)) / inverse_s, pi);  // 2 s atanh t
  return wrap_once((second ? line.mu[1] : line.mu[0]) + (is_left ? -x : x));
}

/// Draws from the uniform part, which has the probability that is left after all components. u in [below, 1).
inline float sample_uniform(float u, float below) {
  constexpr float pi = std::numbers::pi_v<float>;
  return -pi + 2 * pi * std::clamp((u - below) / std::max(1 - below, 1e-6f), 0.0f, 0.9999999f);
}

/// Implements AbsorbedRow::sample() for a mixture. mix: (1 - uniform_share) channel_weights.
inline float sample_mixture(const AbsorbedRow& row, float u, const glm::vec3& mix) {
  const AbsorbedRow* last = &row + row.lines_behind();
  float below = 0;  // probability of the components already passed
  for (const AbsorbedRow* line = &row; line <= last; ++line) {
    const LineMasses of(*line, mix);
    const float both = of.share[0] + of.share[1];
    if (u - below < both) return sample_components(*line, of, u - below);
    below += both;
  }
  return sample_uniform(u, below);
}

/// A row's densities by channel, in lanes 0 to 2. The functions below add its own components and those of the following
/// lines.
inline Float4 uniform_of(const AbsorbedRow& row) { return load4(row, offsetof(AbsorbedRow, uniform) / sizeof(float)); }
inline Float4 components_of(const AbsorbedRow& line, float first_kernel, float second_kernel) {
  return first_kernel * load4(line, offsetof(AbsorbedRow, amplitude) / sizeof(float)) +
         second_kernel * load4(line, offsetof(AbsorbedRow, amplitude) / sizeof(float) + 3);
}
/// Adds the lines of a row from `line` on, two at a time.
inline Float4 components_behind(const AbsorbedRow& row, std::uint32_t line, float x) {
  Float4 sum = splat(0);
  for (const std::uint32_t behind = row.lines_behind(); line <= behind; line += 2) {
    const AbsorbedRow& a = *(&row + line);
    const AbsorbedRow& b = line < behind ? *(&row + line + 1) : zero_density_row;
    const Float4 kernel = logistic_kernels(x, a, b);
    sum += components_of(a, kernel[0], kernel[1]) + components_of(b, kernel[2], kernel[3]);
  }
  return sum;
}

}  // namespace tress::inline v0_2::fiber
