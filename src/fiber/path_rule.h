// A Gauss rule for a distribution of path lengths: it gives a lobe's energy under any absorption from three
// exponentials.
#pragma once

#include <array>

namespace tress::inline v0_2::fiber {

constexpr int path_points = 3;

/// The energy under sigma_a is sum_k weight_k e^(-sigma_a length_k). Weights are >= 0 and sum to the clear energy;
/// lengths are >= 0, in major semi-axes. Points that are not needed have weight 0.
struct PathRule {
  std::array<double, path_points> weight{};
  std::array<double, path_points> length{};
};

/// A measure given by its mass, its mean and its central moments of order 2 to 5 divided by the mass.
struct CentralMoments {
  double mass = 0, mean = 0;
  std::array<double, 4> central{};
};

/// The three-point Gauss rule of a measure, exact for polynomials of degree 5. It has two points or one if the measure
/// has no more, or if rounding hides them. `length` holds its nodes, at least 0.
PathRule gauss_rule(const CentralMoments& moments);

/// Central moments from those about 0: raw[k] = integral of x^k. They are precise for measures that are about as wide
/// as their distance from 0.
CentralMoments central_moments(const std::array<double, 6>& raw);

}  // namespace tress::inline v0_2::fiber
