// The longitudinal lobe of d'Eon et al. 2011: a rough specular cone that conserves energy at every inclination.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/exp_of_negative.h"
#include "base/quarter_sine.h"
#include "fiber/longitudinal.h"

namespace tress::inline v0_2::fiber {

/// A von Mises-Fisher law on the sphere, of concentration 1/v about the specular cone, as a density in dtheta_i of mass
/// 1 over [-pi/2, pi/2]:
///  M = cos theta_i  csch(1/v)/(2v)  e^(-sin theta_i sin t / v)  I_0(cos theta_i cos t / v),
/// where t is the inclination whose cone is at theta_i = -t. The publication's M is per d(sin theta_i); the cosine is
/// that change of measure. It is computed as e^(-2 sin^2 theta_h / v) [I_0(x) e^-x] / (v (1 - e^(-2/v))), theta_h =
/// (theta_i + t)/2, in which nothing overflows or cancels. Sampled as in d'Eon et al. 2013. Immutable plain data; any
/// thread.
class EnergyConservingLobe {
 public:
  /// theta_r: known inclination. tilt: shift of theta_h, so that t = theta_r - 2 tilt (turned back at the poles).
  /// variance: v, the variance of theta_i if theta_r is 0 and v is small, at least that of smallest_lambda. Radians.
  EnergyConservingLobe(float theta_r, float tilt, float variance)
      : variance_(std::max(variance, variance_of(smallest_lambda))) {
    const float turned = theta_r - 2 * tilt;
    sine_ = std::sin(turned);
    cosine_ = std::abs(std::cos(turned));
    t_ = std::atan2(sine_, cosine_);
    span_ = -std::expm1(-2 / variance_);
  }
  /// The variance of theta_i of a logistic of scale lambda in theta_h: (2 pi/sqrt 3 lambda)^2.
  static constexpr float variance_of(float lambda) {
    constexpr float deviation = 2 * std::numbers::pi_v<float> * std::numbers::inv_sqrt3_v<float>;
    return deviation * deviation * lambda * lambda;
  }

  /// 1/rad, in dtheta_i, for theta_i in [-pi/2, pi/2].
  float density(float theta_i) const {
    const float cosine = quarter_cosine(theta_i), sine_h = std::sin(0.5f * (theta_i + t_));
    return cosine * exp_of_negative(-2 * sine_h * sine_h / variance_) * scaled_bessel(cosine * cosine_ / variance_) /
           (variance_ * span_);
  }
  /// u_1, u_2 in [0, 1). theta_i in [-half_pi, half_pi].
  float sample(float u_1, float u_2) const {
    const float from_one =
        std::clamp(-variance_ * std::log1p(-u_1 * span_), 0.0f, 2.0f);  // 1 - cos, about the cone's axis
    const float along = 1 - from_one, across = std::sqrt(from_one * (2 - from_one));
    const float turn = 2 * std::numbers::pi_v<float> * u_2, in_plane = across * std::cos(turn);
    const float radial = along * cosine_ + in_plane * sine_, sideways = across * std::sin(turn);
    const float theta_i = std::atan2(in_plane * cosine_ - along * sine_, std::hypot(radial, sideways));
    return std::clamp(theta_i, -half_pi, half_pi);
  }

 private:
  /// I_0(x) e^-x for x >= 0, error below 3e-7 (Abramowitz and Stegun 9.8.1 and 9.8.2).
  static float scaled_bessel(float x) {
    if (x < 3.75f) {
      const float y = x * x * (1 / 14.0625f);
      const float series =
          1 +
          y * (3.5156229f + y * (3.0899424f + y * (1.2067492f + y * (0.2659732f + y * (0.0360768f + y * 0.0045813f)))));
      return series * exp_of_negative(-x);
    }
    const float y = 3.75f / x;
    const float series =
        0.39894228f +
        y * (0.01328592f +
             y * (0.00225319f +
                  y * (-0.00157565f +
                       y * (0.00916281f +
                            y * (-0.02057706f + y * (0.02635537f + y * (-0.01647633f + y * 0.00392377f)))))));
    return series / std::sqrt(x);
  }

  float variance_, sine_ = 0, cosine_ = 1, t_ = 0;
  float span_;  ///< 1 - e^(-2/v)
};

}  // namespace tress::inline v0_2::fiber
