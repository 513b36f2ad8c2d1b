// Gauss-Legendre quadrature with any number of points.
#pragma once

#include <vector>

namespace tress::inline v0_2 {

/// Nodes in (-1, 1), rising and exactly symmetric, and their weights, which sum to 2.
struct GaussLegendre {
  std::vector<double> node, weight;
};

/// points >= 1; exact for polynomials of degree 2 points - 1. Uses Newton's method on P_n; the time grows with points^2
/// (65536 take some 10 s, 100 some 0.1 ms). Errors of nodes and weights are some 1e-15 up to a thousand points.
GaussLegendre gauss_legendre(int points);

}  // namespace tress::inline v0_2
