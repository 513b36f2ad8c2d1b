// ESTIMATOR.md E1 in doubles, written down once more: what mixtures are tested against.
#pragma once

#include <cmath>
#include <numbers>

#include "tress/adaptive/mixture.h"

namespace tress::test {

inline double side_mass(double s) { return s * std::tanh(std::numbers::pi / (2 * s)) / 2; }

/// p(phi), 1/rad; radians in any turn.
inline double density(const adaptive::SkewLogistic& shape, double phi) {
  const double left = shape.s_left, right = shape.s_right;
  const double x = std::remainder(phi - static_cast<double>(shape.mu), 2 * std::numbers::pi);
  const double e = std::exp(-std::abs(x) / (x < 0 ? left : right));
  return e / ((1 + e) * (1 + e)) / (side_mass(left) + side_mass(right));
}

/// f(phi), 1/rad.
inline double density(const adaptive::Mixture& fit, double phi) {
  double sum = static_cast<double>(fit.uniform_weight) / (2 * std::numbers::pi);
  for (const adaptive::Component& part : fit.parts())
    sum += static_cast<double>(part.weight) * density(part.shape, phi);
  return sum;
}

/// Mass of p between mu - pi and mu + x, x in [-pi, pi].
inline double mass_below(const adaptive::SkewLogistic& shape, double x) {
  const double left = shape.s_left, right = shape.s_right, all = side_mass(left) + side_mass(right);
  if (x < 0) return (side_mass(left) - left * std::tanh(-x / (2 * left)) / 2) / all;
  return (side_mass(left) + right * std::tanh(x / (2 * right)) / 2) / all;
}

/// Mass of p between the azimuths from <= to, both in [-pi, pi].
inline double mass_between(const adaptive::SkewLogistic& shape, double from, double to) {
  const double pi = std::numbers::pi, mu = shape.mu;
  // The circle is cut at the antipode of mu: pieces of [from, to] in the turns that it lies in.
  double sum = 0;
  for (const double turn : {-2 * pi, 0.0, 2 * pi}) {
    const double a = std::fmax(from + turn - mu, -pi), b = std::fmin(to + turn - mu, pi);
    if (a < b) sum += mass_below(shape, b) - mass_below(shape, a);
  }
  return sum;
}

}  // namespace tress::test
