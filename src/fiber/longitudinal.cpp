#include "fiber/longitudinal.h"

#include <algorithm>
#include <cmath>

#include "tress/adaptive/exp_of_negative.h"

namespace tress::fiber {

LongitudinalLobe::LongitudinalLobe(float theta_r, float tilt, float lambda)
    : theta_r_(std::clamp(theta_r, -half_pi, half_pi)), tilt_(tilt), lambda_(std::max(lambda, smallest_lambda)) {
  low_ = (0.5f * (theta_r_ - half_pi) - tilt_) / lambda_;
  high_ = (0.5f * (theta_r_ + half_pi) - tilt_) / lambda_;
  nearest_ = std::abs(std::clamp(0.0f, low_, high_));
  // F(b) - F(a) = e^-nearest (1 - e^(low - high)) / ((1 + e^-|low|) (1 + e^-|high|)), whichever side the mode is on.
  // high - low = pi/(2 lambda) is 2 at least (lambda <= 45 degrees), so that 1 - e^(low - high) does not cancel.
  const float mass =
      (1 - adaptive::exp_of_negative(low_ - high_)) /
      ((1 + adaptive::exp_of_negative(-std::abs(low_))) * (1 + adaptive::exp_of_negative(-std::abs(high_))));
  scale_ = 0.5f / (lambda_ * mass);
}

float LongitudinalLobe::density(float theta_i) const {
  const float x = std::abs((0.5f * (theta_i + theta_r_) - tilt_) / lambda_);
  const float decay = adaptive::exp_of_negative(nearest_ - std::max(x, nearest_));
  const float tail = nearest_ > 0 ? 1 + adaptive::exp_of_negative(-x) : 1 + decay;
  return scale_ * decay / (tail * tail);
}

float LongitudinalLobe::sample(float u) const {
  // Solve F(x) = F(low) + u (F(high) - F(low)), mirrored so that low <= 0 and |low| >= |high|. F and its complement
  // S are both sums of positive terms; e^shift is taken out of F, so that it cannot vanish in a tail.
  const bool mirrored = low_ + high_ > 0;
  const double low = mirrored ? -high_ : low_, high = mirrored ? -low_ : high_;
  const double v = mirrored ? 1 - static_cast<double>(u) : static_cast<double>(u);
  const double shift = std::min(high, 0.0);
  const double below = (1 - v) * std::exp(low - shift) / (1 + std::exp(low)) + v / (1 + std::exp(-std::abs(high)));
  const double above = (1 - v) / (1 + std::exp(low)) + v / (1 + std::exp(high));
  double x = shift + std::log(std::max(below, 1e-300) / above);
  x = std::clamp(x, low, high);
  const double theta_h = tilt_ + lambda_ * (mirrored ? -x : x);
  return std::clamp(static_cast<float>(2 * theta_h - theta_r_), -half_pi, half_pi);
}

}  // namespace tress::fiber
