#include "fiber/row_axes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fiber/fourier_reference.h"
#include "fiber/reference_data.h"
#include "tress/adaptive/mixture.h"
#include "tress/fiber/elliptical_model.h"

namespace {

using namespace tress;
using test::degree;
constexpr float pi = std::numbers::pi_v<float>;

TEST(RowAxes, CoverTheQuarterTurnAndGrazing) {
  for (double sigma : {4.0, 5.0, 10.0, 20.0, 45.0}) {
    const auto slice = fiber::elliptical_slice(2, 1.55f, 0.85f, float(sigma * degree));
    EXPECT_EQ(slice.axis_a.front(), 0);
    EXPECT_FLOAT_EQ(slice.axis_a.back(), pi / 2);
    EXPECT_LE(slice.axis_a[1], sigma * degree / 3 * 1.0002);
    EXPECT_EQ(slice.axis_b.front(), 0);
    EXPECT_NEAR(slice.axis_b.back(), 89.9 * degree, 1e-6);
    EXPECT_TRUE(std::is_sorted(slice.axis_a.begin(), slice.axis_a.end(), std::less_equal<>()) ||
                std::adjacent_find(slice.axis_a.begin(), slice.axis_a.end(), std::greater_equal<>()) ==
                    slice.axis_a.end());
    EXPECT_EQ(std::adjacent_find(slice.axis_b.begin(), slice.axis_b.end(), std::greater_equal<>()), slice.axis_b.end());
    EXPECT_EQ(slice.key.lobe, 2u);
    EXPECT_EQ(slice.blur_rad, float(sigma * degree));
  }
  EXPECT_EQ(fiber::azimuth_axis(0.85f, float(1 * degree)), fiber::azimuth_axis(0.85f, float(4 * degree)));
  EXPECT_EQ(fiber::azimuth_axis(0.85f, float(5 * degree)).size(), 55u);
  EXPECT_EQ(fiber::azimuth_axis(1, 0.1f).size(), 1u);
}

TEST(Folding, KeepsTheDensity) {
  // N(phi_r -> phi_i) of any direction equals that of the folded one at the folded relative azimuth, to float azimuths
  // times the slope of N (< 10 / rad^2).
  fiber::ReferenceRequest request;
  request.theta_d = 0.5;
  request.p = 2;
  request.nodes = 1024;
  for (float phi_r : {0.3f, -0.3f, 2.0f, -2.0f, 3.1f, -3.1f, 7.0f, 0.0f, -pi, pi / 2}) {
    request.phi_r = phi_r;
    const fiber::FourierReference direct(request);
    const fiber::FoldedAzimuth folded = fiber::fold_azimuth(phi_r);
    ASSERT_GE(folded.phi, 0);
    ASSERT_LE(folded.phi, pi / 2);
    request.phi_r = folded.phi;
    const fiber::FourierReference row(request);
    for (float phi_i = -3; phi_i < pi; phi_i += 0.25f) {
      const float x = folded.relative(phi_i, phi_r);
      EXPECT_NEAR(row.density(double(folded.phi) + x), direct.density(phi_i), 1e-5) << phi_r << ' ' << phi_i;
      EXPECT_NEAR(adaptive::wrap_angle(folded.absolute(x, phi_r) - phi_i), 0, 2e-6);
    }
  }
}

TEST(RowGrid, ChoosesNodesSoThatTheMeanInterpolates) {
  const auto slice = fiber::elliptical_slice(1, 1.55f, 0.85f, 0.2f);
  const fiber::RowGrid grid(slice);
  constexpr int n = 1000;
  for (float phi : {0.0f, 0.31f, 1.1f, pi / 2}) {
    for (float theta : {0.0f, 0.4f, -0.9f, 1.3f, 1.55f, 1.568f}) {
      double mean_phi = 0, mean_cos = 0;
      for (int i = 0; i < n; ++i) {
        const float xi = (i + 0.5f) / n;
        const auto node = grid.choose(phi, theta, xi, xi);
        mean_phi += slice.axis_a.at(node.a) / n;
        mean_cos += std::cos(slice.axis_b.at(node.b)) / n;
      }
      // One xi of n decides either way: a cell over n; float cosines add 1e-7.
      EXPECT_NEAR(mean_phi, phi, 2.0 / n * slice.axis_a[1]);
      EXPECT_NEAR(mean_cos, std::cos(theta), 2.0 / n * 0.04);
    }
  }
  const auto last = grid.choose(1.0f, pi / 2, 0, 0);
  EXPECT_EQ(last.b, slice.axis_b.size() - 1);
  const auto corner = grid.choose(pi / 2, -pi / 2, 0.99999994f, 0.99999994f);
  EXPECT_EQ(corner.a, slice.axis_a.size() - 1);
  EXPECT_EQ(grid.choose(0, 0, 0, 0).a, 0u);
  EXPECT_EQ(grid.choose(0, 0, 0, 0.99999994f).b, 0u);
}

TEST(RowGrid, ARoundFiberHasOneAzimuth) {
  const auto slice = fiber::elliptical_slice(1, 1.55f, 1.0f, 0.2f);
  const fiber::RowGrid grid(slice);
  EXPECT_EQ(grid.choose(1.2f, 0.3f, 0.9f, 0.1f).a, 0u);
}

}  // namespace
