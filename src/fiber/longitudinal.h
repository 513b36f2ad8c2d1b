// Longitudinal lobe M: a logistic, Gaussian or Cauchy law in theta_h, truncated (paper eq. 3 and figure 4).
#pragma once

#include <algorithm>
#include <cmath>

#include "base/exp_of_negative.h"
#include "base/float4.h"
#include "base/logarithm.h"
#include "tress/fiber/parameters.h"

namespace tress::inline v0_2::fiber {

/// The largest float below pi/2. Inclinations of directions are clamped to it, so that their cosine is positive.
constexpr float half_pi = 0x1.921fb4p+0f;
/// Smallest logistic scale in theta_h, radians: 0.25 degree.
constexpr float smallest_lambda = 0.0043633231f;

/// The logistic scale of a LongitudinalLobe whose Cauchy law has the scale 1: 1/(2 acosh(sqrt 2)).
constexpr float lambda_of_cauchy = 0.56729633f;

/// M(theta_i) = 1/2 l(theta_h; tilt, width) / (F(b) - F(a)), theta_h = (theta_i + theta_r)/2, a, b = (-+pi/2 +
/// theta_r)/2, where l and F are density and distribution of the law. M is a density in dtheta_i of mass 1 over [-pi/2,
/// pi/2]. All laws have the half width at half maximum of the logistic of scale lambda, 2 acosh(sqrt 2) lambda = 1.763
/// lambda: the Gaussian has the standard deviation 1.497 lambda, the Cauchy law the scale 1.763 lambda. The factor at
/// the nearest point of the range is removed from numerator and mass alike, so no theta_r, tilt or lambda overflows or
/// divides by 0. Immutable plain data; any thread.
class LongitudinalLobe {
 public:
  /// theta_r: known inclination, clamped to +-half_pi. tilt: shift of theta_h; theta_i moves by twice as much. lambda:
  /// logistic scale in theta_h, at least smallest_lambda. Radians.
  LongitudinalLobe(float theta_r, float tilt, float lambda, LongitudinalShape shape = LongitudinalShape::logistic)
      : shape_(shape) {
    const float inverse_width = inverse_width_factor(shape) / std::max(lambda, smallest_lambda);
    slope_ = 0.5f * inverse_width;
    shift_ = (0.5f * std::clamp(theta_r, -half_pi, half_pi) - tilt) * inverse_width;
    const float low = scaled(-half_pi), high = scaled(half_pi);
    nearest_ = std::abs(std::clamp(0.0f, low, high));
    if (shape != LongitudinalShape::logistic) {
      scale_ = scale_of_shape();
      return;
    }
    // F(b) - F(a) = e^-nearest (1 - e^(low - high)) / ((1 + e^-|low|) (1 + e^-|high|)) on whichever side the mode is.
    // high - low = pi/(2 lambda) is at least 2 (lambda <= 45 degrees), so 1 - e^(low - high) does not cancel.
    const float e_low = exp_of_negative(-std::abs(low)), e_high = exp_of_negative(-std::abs(high));
    const float e_span = nearest_ > 0 ? exp_of_negative(low - high) : e_low * e_high;
    scale_ = slope_ * (1 + e_low) * (1 + e_high) / (1 - e_span);
  }

  /// 1/rad, in dtheta_i, for theta_i in [-pi/2, pi/2].
  float density(float theta_i) const {
    const float x = std::abs(scaled(theta_i));
    if (shape_ != LongitudinalShape::logistic) return density_of_shape(x);
    const float decay = exp_of_negative(nearest_ - std::max(x, nearest_));
    const float tail = nearest_ > 0 ? 1 + exp_of_negative(-x) : 1 + decay;
    return scale_ * decay / (tail * tail);
  }
  /// Returns density(theta_i) of the lobe with these arguments, for a lobe that is evaluated once: it takes one vector
  /// of exponentials.
  static float density_of(float theta_r, float tilt, float lambda, LongitudinalShape shape, float theta_i) {
    if (shape != LongitudinalShape::logistic) return LongitudinalLobe(theta_r, tilt, lambda, shape).density(theta_i);
    const float inverse_width = 1 / std::max(lambda, smallest_lambda), slope = 0.5f * inverse_width;
    const float shift = (0.5f * std::clamp(theta_r, -half_pi, half_pi) - tilt) * inverse_width;
    const float low = shift - half_pi * slope, high = shift + half_pi * slope;
    const float nearest = std::abs(std::clamp(0.0f, low, high)), x = std::abs(theta_i * slope + shift);
    const Float4 e =
        exp_of_negative(Float4{-std::abs(low), -std::abs(high), low - high, nearest - std::max(x, nearest)});
    const float tail = 1 + e[3] * (nearest > 0 ? std::max(e[0], e[1]) : 1);  // 1 + e^-x
    return slope * (1 + e[0]) * (1 + e[1]) * e[3] / ((1 - e[2]) * tail * tail);
  }
  /// The inverse CDF, for u in [0, 1]. theta_i in [-half_pi, half_pi].
  float sample(float u) const {
    if (shape_ != LongitudinalShape::logistic) return sample_of_shape(u);
    const float low = scaled(-half_pi), high = scaled(half_pi);
    const Float4 e = exp_of_negative(Float4{-std::abs(low), -std::abs(high), low - high, 0});
    return theta_of(logistic_quantile({low, high, e[0], e[1], e[2]}, u), slope_, shift_);
  }

 private:
  friend class LongitudinalLobes;
  /// A range of the standard logistic law, low < high, and e^-|low|, e^-|high|, e^(low - high).
  struct Range {
    float low, high, e_low, e_high, e_span;
  };
  /// Returns x in the range with the share u of its mass below it. Exact to some 1e-7 widths.
  static float logistic_quantile(const Range& range, float u) {
    // Solves F(x) = F(low) + u (F(high) - F(low)), mirrored so that |low| >= |high|: the tail is then computed from the
    // side where it does not vanish. F and its complement are both sums of positive terms; the factor e^shift is
    // removed from F, so that it cannot vanish in a tail.
    const bool mirrored = range.low + range.high > 0;
    const float high = mirrored ? -range.low : range.high, v = mirrored ? 1 - u : u;
    const float e_far = mirrored ? range.e_high : range.e_low, e_near = mirrored ? range.e_low : range.e_high;
    const float at_low = (1 - v) * (1 + e_near), at_high = v * (1 + e_far);
    const float below = at_low * (high < 0 ? range.e_span : e_far) + at_high;
    const float above = at_low + at_high * (high > 0 ? e_near : 1.0f);
    const float x = std::min(high, 0.0f) + natural_log(below / above);
    return std::clamp(mirrored ? -x : x, range.low, range.high);
  }
  static float theta_of(float x, float slope, float shift) {
    return std::clamp((x - shift) / slope, -half_pi, half_pi);
  }
  LongitudinalLobe(float slope, float shift, float nearest, float scale, LongitudinalShape shape)
      : slope_(slope), shift_(shift), nearest_(nearest), scale_(scale), shape_(shape) {}
  /// The logistic scale divided by the width of the law that has the same half width.
  static float inverse_width_factor(LongitudinalShape shape) {
    return shape == LongitudinalShape::logistic   ? 1.0f
           : shape == LongitudinalShape::gaussian ? 0.66794038f
                                                  : lambda_of_cauchy;
  }
  /// Returns (theta_h - tilt) in widths.
  float scaled(float theta_i) const { return theta_i * slope_ + shift_; }
  float scale_of_shape() const;
  float density_of_shape(float x) const;
  float sample_of_shape(float u) const;

  float slope_, shift_;  ///< the coefficients of scaled()
  float nearest_;        ///< |x| of the point of the range nearest to the mode
  float scale_;          ///< 1/(2 width) over the scaled mass
  LongitudinalShape shape_;
};

/// Four lobes of one shape and one known direction, in lanes. Immutable plain data; any thread.
class LongitudinalLobes {
 public:
  /// The arguments are those of LongitudinalLobe, lane by lane.
  LongitudinalLobes(float theta_r, Float4 tilt, Float4 lambda, LongitudinalShape shape) : shape_(shape) {
    if (shape != LongitudinalShape::logistic) {
      for (int k = 0; k < 4; ++k) {
        const LongitudinalLobe lobe(theta_r, tilt[k], lambda[k], shape);
        slope_[k] = lobe.slope_;
        shift_[k] = lobe.shift_;
        nearest_[k] = lobe.nearest_;
        scale_[k] = lobe.scale_;
      }
      e_nearest_ = e_low_ = e_high_ = e_span_ = splat(0);
      return;
    }
    const Float4 inverse_width = 1 / max4(lambda, splat(smallest_lambda)), zero = splat(0);
    slope_ = 0.5f * inverse_width;
    shift_ = (0.5f * std::clamp(theta_r, -half_pi, half_pi) - tilt) * inverse_width;
    const Float4 low = shift_ - half_pi * slope_, high = shift_ + half_pi * slope_;
    nearest_ = max4(max4(low, -high), zero);
    e_low_ = exp_of_negative(-abs4(low));
    e_high_ = exp_of_negative(-abs4(high));
    e_span_ = exp_of_negative(low - high);
    scale_ = slope_ * (1 + e_low_) * (1 + e_high_) / (1 - e_span_);
    e_nearest_ = nearest_ > zero ? max4(e_low_, e_high_) : splat(1);
  }

  Float4 density(float theta_i) const {
    if (shape_ != LongitudinalShape::logistic) {
      return Float4{lane(0).density(theta_i), lane(1).density(theta_i), lane(2).density(theta_i),
                    lane(3).density(theta_i)};
    }
    const Float4 x = max4(abs4(theta_i * slope_ + shift_), nearest_);
    const Float4 decay = exp_of_negative(nearest_ - x), tail = 1 + decay * e_nearest_;
    return scale_ * decay / (tail * tail);
  }
  LongitudinalLobe lane(int k) const { return {slope_[k], shift_[k], nearest_[k], scale_[k], shape_}; }
  /// Returns lane(k).sample(u).
  float sample(int k, float u) const {
    if (shape_ != LongitudinalShape::logistic) return lane(k).sample(u);
    const float slope = slope_[k], shift = shift_[k], reach = half_pi * slope;
    return LongitudinalLobe::theta_of(
        LongitudinalLobe::logistic_quantile({shift - reach, shift + reach, e_low_[k], e_high_[k], e_span_[k]}, u),
        slope, shift);
  }

 private:
  Float4 slope_, shift_, nearest_, scale_;  ///< the same as in LongitudinalLobe
  Float4 e_nearest_;                        ///< e^-nearest
  Float4 e_low_, e_high_, e_span_;          ///< the same as in LongitudinalLobe::Range
  LongitudinalShape shape_;
};

}  // namespace tress::inline v0_2::fiber
