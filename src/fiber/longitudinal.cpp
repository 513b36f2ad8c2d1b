#include "fiber/longitudinal.h"

#include <numbers>

namespace tress::inline v0_2::fiber {
namespace {

/// e^(x^2) erfc(x), x >= 0; uses the asymptotic series where erfc underflows (error 15/(8 x^6) < 1e-8).
double scaled_erfc(double x) {
  if (x < 25) return std::exp(x * x) * std::erfc(x);
  const double z = 1 / (2 * x * x);
  return std::numbers::inv_sqrtpi / x * (1 - z * (1 - 3 * z));
}

/// The mass of the standard normal law in [a, b], a <= b, times e^(nearest^2/2). It does not underflow if nearest is
/// the distance from 0 of a range that contains [a, b].
double normal_mass(double a, double b, double nearest) {
  if (b < 0) return normal_mass(-b, -a, nearest);
  constexpr double root = std::numbers::sqrt2 / 2;
  if (a < 0) return 0.5 * (std::erf(b * root) - std::erf(a * root));
  const auto above = [&](double x) {
    return 0.5 * std::exp(-0.5 * (x - nearest) * (x + nearest)) * scaled_erfc(x * root);
  };
  return above(a) - above(b);
}

/// Returns x in [low, high] with the share v of the normal mass of [low, high] below it, by Newton's method, with
/// bisection if a step leaves the bracket. low <= 0 or nearest = low.
double normal_quantile(double low, double high, double nearest, double v) {
  const double mass = normal_mass(low, high, nearest);
  double from = low, to = high;
  // If the range begins in a tail, the law is nearly exponential there.
  double x = low > 1 ? low - std::log1p(-v * -std::expm1(low * (low - high))) / low : 0.5 * (low + high);
  for (int step = 0; step < 100; ++step) {
    if (!(x > from && x < to)) x = 0.5 * (from + to);
    const double excess = normal_mass(low, x, nearest) - v * mass;
    (excess > 0 ? to : from) = x;
    const double density =
        std::exp(-0.5 * (x - nearest) * (x + nearest)) * std::numbers::inv_sqrtpi / std::numbers::sqrt2;
    const double next = x - excess / std::max(density, 1e-300);
    if (std::abs(next - x) < 1e-9 * (1 + std::abs(x)) || to - from < 1e-12) break;
    x = next;
  }
  return std::clamp(x, low, high);
}

/// atan(high) - atan(low), without cancellation.
double cauchy_mass(double low, double high) { return std::atan2(high - low, 1 + low * high); }

}  // namespace

float LongitudinalLobe::scale_of_shape() const {
  const double low = static_cast<double>(scaled(-half_pi)), high = static_cast<double>(scaled(half_pi));
  const double mass = shape_ == LongitudinalShape::cauchy ? cauchy_mass(low, high)
                                                          : normal_mass(low, high, static_cast<double>(nearest_)) *
                                                                std::numbers::sqrt2 / std::numbers::inv_sqrtpi;
  return static_cast<float>(static_cast<double>(slope_) / mass);
}

float LongitudinalLobe::density_of_shape(float x) const {
  if (shape_ == LongitudinalShape::cauchy) return scale_ / (1 + x * x);
  return scale_ * exp_of_negative(-0.5f * std::max(x - nearest_, 0.0f) * (x + nearest_));
}

float LongitudinalLobe::sample_of_shape(float u) const {
  // The same as for the logistic, in doubles; the Gaussian is mirrored so that |low| <= |high|.
  const double first = static_cast<double>(scaled(-half_pi)), last = static_cast<double>(scaled(half_pi));
  const double v = static_cast<double>(u);
  double x = 0;
  if (shape_ == LongitudinalShape::cauchy) {
    const double angle = v * cauchy_mass(first, last), s = std::sin(angle), c = std::cos(angle);
    x = (first * c + s) / std::max(c - first * s, 1e-300);
  } else {
    const bool mirrored = first + last < 0;
    const double low = mirrored ? -last : first, high = mirrored ? -first : last;
    x = normal_quantile(low, high, static_cast<double>(nearest_), mirrored ? 1 - v : v);
    if (mirrored) x = -x;
  }
  x = std::clamp(x, first, last);
  const double theta_i = (x - static_cast<double>(shift_)) / static_cast<double>(slope_);
  return std::clamp(static_cast<float>(theta_i), -half_pi, half_pi);
}

}  // namespace tress::inline v0_2::fiber
