#include "base/gauss_legendre.h"

#include <cmath>
#include <cstddef>
#include <numbers>

namespace tress::inline v0_2 {

GaussLegendre gauss_legendre(int points) {
  const auto n = static_cast<std::size_t>(points);
  GaussLegendre rule{std::vector<double>(n), std::vector<double>(n)};
  for (std::size_t i = 0; i < (n + 1) / 2; ++i) {
    // Tricomi's estimate of the i-th root from above, with an error of O(n^-4).
    const double count = points, angle = std::numbers::pi * (static_cast<double>(i) + 0.75) / (count + 0.5);
    double x = (1 - (count - 1) / (8 * count * count * count)) * std::cos(angle);
    double slope = 1;
    if (2 * i + 1 == n) x = 0;
    for (int step = 0; step < 10; ++step) {
      double below = 1, value = x;  // P_(k-1), P_k
      for (int k = 2; k <= points; ++k) {
        const double next = ((2 * k - 1) * x * value - (k - 1) * below) / k;
        below = value;
        value = next;
      }
      slope = count * (below - x * value) / ((1 - x) * (1 + x));
      const double change = value / slope;
      x -= change;
      if (std::abs(change) < 1e-15) break;
    }
    const double weight = 2 / ((1 - x) * (1 + x) * slope * slope);
    rule.node[i] = -x;
    rule.node[n - 1 - i] = x;
    rule.weight[i] = rule.weight[n - 1 - i] = weight;
  }
  return rule;
}

}  // namespace tress::inline v0_2
