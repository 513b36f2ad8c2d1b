// Gauss-Legendre rules of any size: symmetric, and exact for every polynomial that they ought to be exact for.
#include "base/gauss_legendre.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <numeric>

namespace tress {
namespace {

TEST(gauss_legendre, rules_are_symmetric_and_positive_and_weigh_2) {
  for (const int points : {1, 2, 3, 4, 10, 35, 70, 100, 1001}) {
    const GaussLegendre rule = gauss_legendre(points);
    const auto n = static_cast<std::size_t>(points);
    ASSERT_EQ(rule.node.size(), n);
    for (std::size_t i = 0; i < n; ++i) {
      EXPECT_EQ(rule.node[i], -rule.node[n - 1 - i]);
      EXPECT_EQ(rule.weight[i], rule.weight[n - 1 - i]);
      EXPECT_GT(rule.weight[i], 0);
      EXPECT_LT(std::abs(rule.node[i]), 1);
      if (i > 0) {
        EXPECT_GT(rule.node[i], rule.node[i - 1]);
      }
    }
    // Each weight is good to some 1e-15 times the slope's sensitivity; n of them add up.
    EXPECT_NEAR(std::accumulate(rule.weight.begin(), rule.weight.end(), 0.0), 2, 1e-12) << points;
  }
}

// Degree 2n - 1 is exact, degree 2n is not: for n = 2 the error of x^4 is 8/45.
TEST(gauss_legendre, polynomials_of_degree_twice_the_points_less_one_are_integrated_exactly) {
  for (const int points : {1, 2, 3, 10, 35, 100}) {
    const GaussLegendre rule = gauss_legendre(points);
    for (int degree = 0; degree < 2 * points; ++degree) {
      double sum = 0;
      for (std::size_t i = 0; i < rule.node.size(); ++i) sum += rule.weight[i] * std::pow(rule.node[i], degree);
      EXPECT_NEAR(sum, degree % 2 == 0 ? 2.0 / (degree + 1) : 0.0, 1e-13) << points << " points, degree " << degree;
    }
  }
  const GaussLegendre two = gauss_legendre(2);
  EXPECT_NEAR(two.weight[0] * std::pow(two.node[0], 4) * 2, 2.0 / 5 - 8.0 / 45, 1e-14);
}

}  // namespace
}  // namespace tress
