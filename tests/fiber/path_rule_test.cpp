#include "fiber/path_rule.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "tress/base/random.h"

namespace {

using namespace tress;

/// Points (weight, x) of a discrete measure.
using Points = std::vector<std::pair<double, double>>;

double power_sum(const Points& points, int degree) {
  double sum = 0;
  for (const auto& [weight, x] : points) sum += weight * std::pow(x, degree);
  return sum;
}

fiber::CentralMoments moments_of(const Points& points) {
  fiber::CentralMoments m;
  for (const auto& [weight, x] : points) {
    m.mass += weight;
    m.mean += weight * x;
  }
  m.mean /= m.mass;
  for (const auto& [weight, x] : points) {
    for (int k = 0; k < 4; ++k) m.central[std::size_t(k)] += weight * std::pow(x - m.mean, k + 2) / m.mass;
  }
  return m;
}

void expect_exact_to_degree_five(const Points& points, const fiber::PathRule& rule) {
  for (int degree = 0; degree <= 5; ++degree) {
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_GE(rule.weight[k], 0);
      sum += rule.weight[k] * std::pow(rule.length[k], degree);
    }
    EXPECT_NEAR(sum, power_sum(points, degree), 1e-9 * power_sum(points, degree)) << degree;
  }
}

TEST(PathRule, IsExactToDegreeFive) {
  RandomStream random(1);
  for (int trial = 0; trial < 200; ++trial) {
    Points points;
    const int n = 3 + int(20 * random.next());
    for (int i = 0; i < n; ++i) points.emplace_back(random.next() + 0.01, 1 + 5 * double(random.next()));
    expect_exact_to_degree_five(points, fiber::gauss_rule(moments_of(points)));
  }
}

TEST(PathRule, TakesFewerPointsWhereTheMeasureHasFewer) {
  const Points two{{0.3, 1.5}, {0.1, 2.5}};
  const fiber::PathRule rule = fiber::gauss_rule(moments_of(two));
  expect_exact_to_degree_five(two, rule);
  EXPECT_EQ(rule.weight[2], 0);

  const Points one{{0.25, 3.0}};
  const fiber::PathRule single = fiber::gauss_rule(moments_of(one));
  EXPECT_EQ(single.weight[0], 0.25);
  EXPECT_EQ(single.length[0], 3.0);
  EXPECT_EQ(single.weight[1] + single.weight[2], 0);

  const fiber::PathRule nothing = fiber::gauss_rule({});
  EXPECT_EQ(nothing.weight[0] + nothing.weight[1] + nothing.weight[2], 0);
}

TEST(PathRule, NearlyDegenerateMeasuresStaySane) {
  // From three points through all stages to two and one: weights never negative, lengths never outside.
  for (double spread = 1; spread > 1e-12; spread /= 3) {
    for (const Points& points : {Points{{1, 2}, {1, 2 + spread}, {1, 2 + 2 * spread}},
                                 Points{{1, 2}, {1, 3}, {1e-3, 3 + spread}}, Points{{1, 2}, {1, 3}, {spread, 2.5}}}) {
      const double longest = std::max({points[0].second, points[1].second, points[2].second});
      const fiber::PathRule rule = fiber::gauss_rule(moments_of(points));
      double mass = 0, mean = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_GE(rule.weight[k], 0);
        if (rule.weight[k] > 1e-6) {
          EXPECT_GE(rule.length[k], 2 - 1e-3);
          EXPECT_LE(rule.length[k], longest + 1e-3);
        }
        mass += rule.weight[k];
        mean += rule.weight[k] * rule.length[k];
      }
      EXPECT_NEAR(mass, power_sum(points, 0), 1e-6);
      EXPECT_NEAR(mean, power_sum(points, 1), 1e-5);
    }
  }
}

TEST(PathRule, CentralMomentsAgreeWithRawOnes) {
  const Points points{{0.2, 0.3}, {0.5, 0.6}, {0.1, 0.9}, {0.7, 0.1}};
  std::array<double, 6> raw;
  for (int k = 0; k < 6; ++k) raw[std::size_t(k)] = power_sum(points, k);
  const auto direct = moments_of(points), converted = fiber::central_moments(raw);
  EXPECT_NEAR(converted.mass, direct.mass, 1e-15);
  EXPECT_NEAR(converted.mean, direct.mean, 1e-15);
  for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(converted.central[k], direct.central[k], 1e-14);
}

}  // namespace
