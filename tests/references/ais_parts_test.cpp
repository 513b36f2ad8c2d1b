// The parts of the paper's fit one by one: derivatives, steps, regression, p-values.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "references/ais_targets.h"
#include "references/learners/ais_problem.h"
#include "references/learners/ais_proposal.h"
#include "references/learners/ais_regression.h"
#include "references/learners/ais_step.h"
#include "references/learners/ais_stop.h"
#include "references/learners/nnls.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::adaptive {
namespace {

using tress::testing::two_lobes;

constexpr double pi = std::numbers::pi;

AisParts some_parts() { return {{{0.3, 0.12, 0.3}, {2.7, 0.4, 0.2}, {-1.4, 0.25, 0.15}}, {0.9, 0.4, 0.2}, 0.1}; }

// A sample that is spread evenly, with weights that are not all the same.
AisProblem problem_of(AisDistance distance, AisBasis basis, const AisParts& parts, double tau = 10, int samples = 200) {
  const AisTarget target = two_lobes();
  AisProblem problem(distance, basis, tau);
  std::vector<double> azimuth, g, cells;
  for (int i = 0; i < samples; ++i) {
    azimuth.push_back(-pi + 2 * pi * (i + 0.37) / samples);
    g.push_back(target.density(static_cast<float>(azimuth.back())) / target.energy);
    cells.push_back((1 + 0.5 * std::sin(3.0 * i)) / samples);
  }
  problem.set_sample(azimuth, g, cells, target.density(3.14159f) / target.energy);
  problem.set_parts(parts);
  return problem;
}

AisParts moved(AisParts parts, std::size_t parameter, double by) {
  AisShape& shape = parts.shapes[parameter / 3];
  if (parameter % 3 == 0) shape.mu += by;
  if (parameter % 3 == 1) shape.left *= std::exp(by);
  if (parameter % 3 == 2) shape.right *= std::exp(by);
  return parts;
}

struct Case {
  AisDistance distance;
  AisBasis basis;
};

class AisDerivatives : public ::testing::TestWithParam<Case> {};

// Central differences: truncation h^2/6 O''' with O''' up to O/s^3, so h = 1e-5 leaves 1e-8, rounding 1e-16 O/h 1e-11
// (the kernel's exp: 1e-11 O/h = 1e-6 at worst). p has a step in its second derivative at mu, which samples straddle:
// 200 samples are 0.03 apart, and h moves none across.
TEST_P(AisDerivatives, OfBAgreeWithFiniteDifferences) {
  const auto [distance, basis] = GetParam();
  const AisParts parts = some_parts();
  const AisProblem problem = problem_of(distance, basis, parts);
  const AisRange all{0, 3, true};
  const Eigen::VectorXd gradient = problem.shape_gradient(all);
  const Eigen::MatrixXd hessian = problem.shape_hessian(all, true);
  const Eigen::MatrixXd positive = problem.shape_hessian(all, false);
  const double h = 1e-5, scale = gradient.cwiseAbs().maxCoeff();
  for (std::size_t i = 0; i < 9; ++i) {
    const AisProblem up = problem_of(distance, basis, moved(parts, i, h));
    const AisProblem down = problem_of(distance, basis, moved(parts, i, -h));
    const auto at = static_cast<Eigen::Index>(i);
    EXPECT_NEAR(gradient[at], (up.objective() - down.objective()) / (2 * h), 1e-5 * scale) << i;
    const Eigen::VectorXd bend = (up.shape_gradient(all) - down.shape_gradient(all)) / (2 * h);
    for (Eigen::Index j = 0; j < 9; ++j) {
      EXPECT_NEAR(hessian(j, at), bend[j], 1e-4 * hessian.cwiseAbs().maxCoeff()) << i << ' ' << j;
      EXPECT_DOUBLE_EQ(hessian(j, at), hessian(at, j));
    }
    EXPECT_NEAR(problem.shape_curvature(all)[at], positive(at, at), 1e-9 * positive(at, at) + 1e-12);
  }
  // One component's part of the whole: what the sequential scheme moves by.
  EXPECT_LT((problem.shape_hessian({1, 2, false}, true) - hessian.block<3, 3>(3, 3)).norm(), 1e-9 * hessian.norm());
}

TEST_P(AisDerivatives, OfAAgreeWithFiniteDifferences) {
  const auto [distance, basis] = GetParam();
  const AisParts parts = some_parts();
  const AisRange all{0, 3, true};
  const AisProblem problem = problem_of(distance, basis, parts);
  const Eigen::VectorXd gradient = problem.weight_gradient(all);
  const Eigen::MatrixXd hessian = problem.weight_hessian(all);
  const double h = 1e-5;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto changed = [&](double by) {
      AisParts other = parts;
      (i < 3 ? other.a[i] : other.uniform) += by;
      return problem_of(distance, basis, other);
    };
    const AisProblem up = changed(h), down = changed(-h);
    const auto at = static_cast<Eigen::Index>(i);
    EXPECT_NEAR(gradient[at], (up.objective() - down.objective()) / (2 * h), 1e-6);
    const Eigen::VectorXd bend = (up.weight_gradient(all) - down.weight_gradient(all)) / (2 * h);
    for (Eigen::Index j = 0; j < 4; ++j) EXPECT_NEAR(hessian(j, at), bend[j], 1e-5 * hessian.cwiseAbs().maxCoeff());
  }
}

// Newton and gradient: O falls by every step that says so, and 40 steps of Newton end no higher than 40 of the
// gradient.
TEST_P(AisDerivatives, StepsDescendAndNewtonIsNoWorse) {
  const auto [distance, basis] = GetParam();
  double reached[2];
  for (const AisStep kind : {AisStep::newton, AisStep::gradient}) {
    AisProblem problem = problem_of(distance, basis, some_parts());
    AisStepper stepper(kind, 3);
    const AisRange all{0, 3, true};
    for (int i = 0; i < 40; ++i) {
      const double before = problem.objective();
      if (stepper.step(problem, all)) {
        EXPECT_LT(problem.objective(), before);
      } else {
        EXPECT_EQ(problem.objective(), before);
      }
      const double stepped = problem.objective();
      regress_weights(problem, all);
      EXPECT_LE(problem.objective(), stepped);
      for (const double a : problem.parts().a) EXPECT_GE(a, 0);
      EXPECT_GE(problem.parts().uniform, 0);
    }
    reached[kind == AisStep::newton ? 0 : 1] = problem.objective();
  }
  EXPECT_LE(reached[0], 1.02 * reached[1]);
}

INSTANTIATE_TEST_SUITE_P(All, AisDerivatives,
                         ::testing::Values(Case{AisDistance::l2, AisBasis::circular},
                                           Case{AisDistance::l2, AisBasis::line},
                                           Case{AisDistance::relative_entropy, AisBasis::circular},
                                           Case{AisDistance::relative_entropy, AisBasis::line}));

// L2 in a alone is quadratic: one regression is at the minimum, where the gradient is 0 or the weight is.
TEST(AisRegression, MeetsTheConditionsOfTheMinimum) {
  AisParts parts = some_parts();
  parts.shapes.push_back({2.0, 0.3, 0.3});  // where g has a valley: its best weight would be negative
  parts.a.push_back(0.3);
  AisProblem problem = problem_of(AisDistance::l2, AisBasis::circular, parts);
  const AisRange all{0, 4, true};
  regress_weights(problem, all);
  const Eigen::VectorXd gradient = problem.weight_gradient(all);
  bool bound = false;
  for (Eigen::Index i = 0; i < 5; ++i) {
    const double a = i < 4 ? problem.parts().a[static_cast<std::size_t>(i)] : problem.parts().uniform;
    EXPECT_GE(a, 0);
    EXPECT_GE(gradient[i], -1e-9);
    EXPECT_NEAR(a * gradient[i], 0, 1e-9);
    bound = bound || a == 0;
  }
  EXPECT_TRUE(bound) << "a >= 0 has had nothing to do";
}

// The larger tau, the less f(pi) and f(-pi) differ on the line.
TEST(AisPeriodicity, TheTermClosesTheEnds) {
  double before = 1e30;
  for (const double tau : {0.0, 1.0, 10.0, 1000.0}) {
    AisProblem problem = problem_of(AisDistance::l2, AisBasis::line, some_parts(), tau);
    AisStepper stepper(AisStep::newton, 3);
    for (int i = 0; i < 30; ++i) {
      stepper.step(problem, {0, 3, true});
      regress_weights(problem, {0, 3, true});
    }
    const auto end = [&](double x) {
      double sum = 0;
      for (std::size_t d = 0; d < 3; ++d) {
        const AisShape& shape = problem.parts().shapes[d];
        const double y = std::abs(x - shape.mu) / (x < shape.mu ? shape.left : shape.right);
        sum += problem.parts().a[d] / std::pow(2 * std::cosh(y / 2), 2);
      }
      return sum;
    };
    const double gap = std::abs(end(pi) - end(-pi));
    EXPECT_LE(gap, before);
    before = gap;
  }
  EXPECT_LT(before, 1e-3);
}

// Masses of sides by midpoints, both bases; the mixture that comes back is the same function on the circle.
TEST(AisProposal, MassesAndTheMixture) {
  const AisParts parts = some_parts();
  for (const AisBasis basis : {AisBasis::circular, AisBasis::line}) {
    const AisProposal proposal(parts, basis, 0.05);
    const Mixture mixture = to_mixture(parts, basis, 2);
    double f = 0, q = 0;
    constexpr int points = 20000;
    for (int i = 0; i < points; ++i) {
      const auto x = static_cast<float>(-pi + 2 * pi * (i + 0.5) / points);
      f += proposal.mixture(x) * 2 * pi / points;
      q += proposal.density(x) * 2 * pi / points;
      if (basis == AisBasis::circular) {
        EXPECT_NEAR(mixture.density(x), 2 * proposal.mixture(x), 1e-5);
      }
    }
    EXPECT_NEAR(f, parts.mass(basis), 1e-6);
    EXPECT_NEAR(q, 1, 1e-6);
    EXPECT_NEAR(mixture.energy(), 2 * parts.mass(basis), 1e-5);
  }
}

TEST(Nnls, MeetsTheConditionsOnRandomProblems) {
  RandomStream random(11);
  const auto normal = [&] { return 2.0 * static_cast<double>(random.next()) - 1; };
  for (int trial = 0; trial < 300; ++trial) {
    const Eigen::Index n = 1 + trial % 9;
    Eigen::MatrixXd p(20, n);
    Eigen::VectorXd g(20);
    for (Eigen::Index i = 0; i < 20; ++i) {
      g[i] = normal();
      for (Eigen::Index j = 0; j < n; ++j) p(i, j) = normal();
    }
    if (trial % 5 == 0 && n > 1) p.col(n - 1) = p.col(0);  // no unique answer
    if (trial % 7 == 0) p.col(0).setZero();
    const Eigen::MatrixXd gram = p.transpose() * p;
    const Eigen::VectorXd right = p.transpose() * g;
    const Eigen::VectorXd x = non_negative_least_squares(gram, right);
    const Eigen::VectorXd slope = gram * x - right;
    for (Eigen::Index i = 0; i < n; ++i) {
      EXPECT_GE(x[i], 0);
      EXPECT_GE(slope[i], -1e-8);
      EXPECT_NEAR(x[i] * slope[i], 0, 1e-7);
    }
  }
}

// Section 5.4: as printed every p-value is 1. Mended, a sequence that has come to rest is stopped; one that falls is
// not.
TEST(AisStop, PrintedNeverStopsAndMendedDoes) {
  RandomStream random(12);
  std::vector<double> rest, falling;
  for (int t = 0; t <= 60; ++t) {
    const double noise = 0.02 * (static_cast<double>(random.next()) - 0.5);
    rest.push_back(-5 + noise);
    falling.push_back(-0.1 * t + noise);
  }
  EXPECT_DOUBLE_EQ(ais_p_value(rest, 15, 0.05, AisStop::printed), 1);
  EXPECT_DOUBLE_EQ(ais_p_product(rest, 15, 0.05, AisStop::printed), 1);
  EXPECT_LT(ais_p_product(rest, 15, 0.05, AisStop::mended), 0.01);
  EXPECT_GT(ais_p_product(falling, 15, 0.05, AisStop::mended), 0.5);
  EXPECT_EQ(ais_p_value(rest, 100, 0.05, AisStop::mended), 1);
  EXPECT_EQ(ais_p_value({}, 15, 0.05, AisStop::mended), 1);
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
