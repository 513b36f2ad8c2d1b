// Tilts and widths of the longitudinal lobes of one fiber, with everything precomputed that does not depend on the
// direction.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>

#include "base/float4.h"
#include "base/quarter_sine.h"
#include "fiber/longitudinal.h"
#include "tress/fiber/parameters.h"

namespace tress::inline v0_2::fiber {

/// The lanes are TT, TRT, TRRT, R: order p is lane_of(p). Tilts are those of the reference models' publications;
/// `elliptical` has its own (as_traced()). Immutable plain data; any thread.
class LobeWidths {
 public:
  LobeWidths() = default;
  explicit LobeWidths(const FiberParameters& fiber) {
    constexpr std::array<float, 4> per_alpha{0.390f, 0.196f, 0.66f, 0.9f}, tilts{-1.0f, 0.5f, 1.5f, 2.5f};
    const float alpha2 = fiber.roughness * fiber.roughness;
    for (int p = 0; p < 4; ++p) {
      const auto lobe = static_cast<std::size_t>(p);
      const std::optional<float>& given = fiber.longitudinal_lambda[lobe];
      lambda_[lane_of(p)] = given.value_or(per_alpha[lobe] * fiber.roughness);
      tilt_[lane_of(p)] = tilts[lobe] * fiber.tilt;
      if (given) continue;
      if (p == 1) by_cosine_ = true;
      if (p > 0) shift_[lane_of(p)] = (p == 1 ? 0.3f : 3.0f) * alpha2;
    }
  }

  /// The widths of `elliptical`, whose TRRT and residual follow traced scales. Such light meets many scales, and each
  /// sends it on towards the tip or back towards the root, so it leaves in a wide range about the specular cone instead
  /// of moving further with every order. So the lane of TRRT has no tilt, and its lambda is larger by the scales' tilt.
  /// With a given lambda, or without a tilt, nothing differs. Fitted to fibers traced in three dimensions
  /// (bench/README.md, residual_lobe).
  static LobeWidths as_traced(const FiberParameters& fiber) {
    LobeWidths widths(fiber);
    const int later = lane_of(3);
    if (fiber.longitudinal_lambda[3]) return widths;
    widths.tilt_[later] = 0;
    widths.lambda_[later] += fiber.tilt;
    return widths;
  }

  static constexpr int lane_of(int p) { return p == 0 ? 3 : p - 1; }

  struct At {
    Float4 tilt;    ///< lobe_tilt()
    Float4 shift;   ///< roughness_shift()
    Float4 lambda;  ///< longitudinal_lambda()
  };
  At at(float theta_r) const {
    const float t = theta_r < 0 ? -theta_r : theta_r;
    const float inverse_cosine = 1 / std::max(quarter_cosine(t), 1e-3f), tangent = quarter_sine(t) * inverse_cosine;
    const Float4 saturation{10, 4, 4, 4};
    const float of_tt = by_cosine_ ? inverse_cosine : 1;
    const Float4 x = shift_ * tangent * Float4{inverse_cosine * inverse_cosine, 1, 1, 1};
    const Float4 lambda = max4(lambda_ * Float4{of_tt, 1, 1, 1}, splat(smallest_lambda)), most = splat(largest_lambda);
    return {tilt_, (theta_r < 0 ? -1.0f : 1.0f) * x * t / (t + saturation * x + 1e-12f), lambda < most ? lambda : most};
  }

 private:
  static constexpr float largest_lambda = 0.785398163f;  ///< 45 degrees
  Float4 tilt_ = splat(0), lambda_ = splat(0);
  Float4 shift_ = splat(0);  ///< x of roughness_shift() at tan = cos = 1
  bool by_cosine_ = false;   ///< whether lambda of TT is proportional to 1/cos theta_r
};

}  // namespace tress::inline v0_2::fiber
