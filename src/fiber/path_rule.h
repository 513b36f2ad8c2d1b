// A Gauss rule of a distribution of path lengths: what a lobe's energy is under any absorption, in three exponentials.
#pragma once

#include <array>

namespace tress::fiber {

constexpr int path_points = 3;

/// Energy under sigma_a = sum_k weight_k e^(-sigma_a length_k). Weights >= 0 and sum to the clear energy; lengths
/// >= 0, in major semi-axes. Points that are not needed have weight 0.
struct PathRule {
  std::array<double, path_points> weight{};
  std::array<double, path_points> length{};
};

/// A measure by its mass, its mean and its central moments of order 2 to 5 divided by the mass.
struct CentralMoments {
  double mass = 0, mean = 0;
  std::array<double, 4> central{};
};

/// The three-point Gauss rule of a measure, exact for polynomials of degree 5; two points or one where the measure has
/// no more, or where rounding hides them. `length` holds its nodes, at least 0.
PathRule gauss_rule(const CentralMoments& moments);

/// Central moments from those about 0: raw[k] = integral of x^k. For measures as wide as their distance from 0.
CentralMoments central_moments(const std::array<double, 6>& raw);

}  // namespace tress::fiber
