// The linear solver of the fits, against Eigen's.
#include "fit/kernels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <vector>

#include "fit/own_eigen.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::adaptive {
namespace {

// Condition numbers up to some 1e5, so that 1e-9 of the solution is four digits above what rounding does.
TEST(Kernels, SolvesEverySizeFromTheLowerHalf) {
  constexpr std::size_t leading = padded_size(40);
  RandomStream random(3);
  for (std::size_t n = 1; n <= 40; ++n) {
    const auto size = static_cast<Eigen::Index>(n);
    Eigen::MatrixXd root(size, size);
    Eigen::VectorXd right(size);
    for (Eigen::Index i = 0; i < size; ++i) {
      right[i] = static_cast<double>(random.next()) - 0.5;
      for (Eigen::Index j = 0; j < size; ++j) root(i, j) = static_cast<double>(random.next()) - 0.5;
    }
    const Eigen::MatrixXd matrix = root * root.transpose() + 1e-3 * Eigen::MatrixXd::Identity(size, size);
    // Above the diagonal stands what does not belong there; the padding below is 0.
    std::vector<double> columns(leading * n, 0.0), x(leading, 0.0);
    for (std::size_t j = 0; j < n; ++j) {
      for (std::size_t i = 0; i < n; ++i) {
        columns[leading * j + i] = i < j ? 1e3 : matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      }
      x[j] = right[static_cast<Eigen::Index>(j)];
    }
    solve_in_place(columns.data(), leading, n, x.data());
    const Eigen::VectorXd expected = matrix.ldlt().solve(right);
    for (std::size_t i = 0; i < n; ++i) {
      EXPECT_NEAR(x[i], expected[static_cast<Eigen::Index>(i)], 1e-9 * expected.norm()) << n;
    }
  }
}

TEST(Kernels, APivotOfNothingLeavesItsEntryZero) {
  constexpr std::size_t leading = kernel_lanes;
  std::vector<double> columns(3 * leading, 0.0), x(leading, 0.0);
  columns[0] = 4;                // x_0 alone
  columns[2 * leading + 2] = 2;  // x_2 alone; of x_1 nothing is known
  x[0] = 8;
  x[1] = 1;
  x[2] = 3;
  solve_in_place(columns.data(), leading, 3, x.data());
  EXPECT_EQ(x[0], 2);
  EXPECT_EQ(x[1], 0);
  EXPECT_EQ(x[2], 1.5);
}

// 1/Z and d ln Z/d ln s, which take a short way where T(s) is 1 to the last bit.
TEST(Kernels, ShapesAgreeWithTheHyperbolicTangent) {
  const double pi = 3.14159265358979323846;
  for (const double s : {0.004, 0.05, 0.0785, 0.0786, 0.2, 0.5, 3.0}) {
    const double t = std::tanh(pi / (2 * s));
    const Shape shape(0, s, s);
    EXPECT_NEAR(shape.inverse_z * s * t, 1, 1e-15);
    EXPECT_NEAR(shape.log_z_left, 0.5 * (1 - (1 - t * t) * pi / (2 * s * t)), 4e-15);
  }
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
