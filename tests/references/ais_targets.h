// Targets for the tests of the paper's fit.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "references/learners/ais.h"
#include "tress/adaptive/mixture.h"

namespace tress::testing {

constexpr double circle = 2 * std::numbers::pi;

/// g with its mass and variation by midpoints.
inline adaptive::AisTarget target_of(std::function<double(float)> g) {
  constexpr int points = 8192;
  double sum = 0, squares = 0;
  for (int i = 0; i < points; ++i) {
    const double value = g(static_cast<float>(-std::numbers::pi + circle * (i + 0.5) / points));
    sum += value;
    squares += value * value;
  }
  const double mean = sum / points;
  const double variation = (squares / points - mean * mean) * circle;
  return {std::move(g), mean * circle, std::max(variation, 1e-3 / circle)};
}

/// Integral of (g - f)^2 over the variation, by midpoints: 8192 of them leave under 1e-6 for scales above 0.01.
inline double relative_l2(const adaptive::AisTarget& target, const adaptive::Mixture& fit) {
  constexpr int points = 8192;
  double sum = 0;
  for (int i = 0; i < points; ++i) {
    const auto x = static_cast<float>(-std::numbers::pi + circle * (i + 0.5) / points);
    const double r = target.density(x) - static_cast<double>(fit.density(x));
    sum += r * r;
  }
  return sum * circle / points / target.variation;
}

/// Two Gaussian lobes, not of the fit's family; the second straddles +-pi where `turn` is 0.
inline adaptive::AisTarget two_lobes(float turn = 0) {
  return target_of([turn](float x) {
    return 0.4 * static_cast<double>(adaptive::wrapped_gaussian(x - 0.5f - turn, 0.15f)) +
           0.3 * static_cast<double>(adaptive::wrapped_gaussian(x - 3.0f - turn, 0.3f));
  });
}

}  // namespace tress::testing
