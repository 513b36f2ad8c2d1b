// Longitudinal lobe M: a truncated logistic in theta_h (paper eq. 3, design section 3).
#pragma once

namespace tress::fiber {

/// The largest float below pi/2: the inclinations of directions are clamped to it, so that their cosine is positive.
constexpr float half_pi = 0x1.921fb4p+0f;
/// Smallest logistic scale in theta_h, radians: .25 degree.
constexpr float smallest_lambda = 0.0043633231f;

/// M(theta_i) = 1/2 l(theta_h; tilt, lambda) / (F(b) - F(a)), theta_h = (theta_i + theta_r)/2,
/// a, b = (-+pi/2 + theta_r)/2: a density in dtheta_i of mass 1 over [-pi/2, pi/2]. Every exponential is of a number
/// <= 0, so no theta_r, tilt or lambda overflows or divides by 0, not even where nearly all of l is cut off.
/// Immutable plain data; any thread.
class LongitudinalLobe {
 public:
  /// theta_r: known inclination, clamped to +-half_pi. tilt: shift of theta_h, so theta_i moves by twice as much.
  /// lambda: logistic scale in theta_h, at least smallest_lambda. Radians.
  LongitudinalLobe(float theta_r, float tilt, float lambda);

  /// 1/rad, in dtheta_i, for theta_i in [-pi/2, pi/2].
  float density(float theta_i) const;
  /// Inverse CDF of u in [0, 1]. theta_i in [-half_pi, half_pi].
  float sample(float u) const;

 private:
  float theta_r_, tilt_, lambda_;
  float low_, high_;  ///< (a - tilt)/lambda, (b - tilt)/lambda
  float nearest_;     ///< |x| of the point of [low, high] nearest to the mode: taken out of numerator and mass
  float scale_;       ///< 1/(2 lambda) over the scaled mass
};

}  // namespace tress::fiber
