// The quadrature over the width of a circular fiber against the oracle, and the fault of few points.
#include "references/models/deon2011_azimuth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include "fiber/reference_data.h"

namespace tress {
namespace {

using fiber::AzimuthalTrace;
using fiber::CircularFiber;
using fiber::OffsetQuadrature;
using test::degree;

constexpr double pi = std::numbers::pi;

double density(const AzimuthalTrace& trace, int p, double phi) {
  return double(trace.shape(p, float(phi)).g) * double(trace.mass(p).g);
}

// columns: id, eta, e, theta_d, phi_i, sigma, sigma_a, p, lobe, energy, n0..n359 at phi_o = -180 + k.
// Error: the exits are float sums of up to 3 pi + 6 asin, good to 3e-6 rad: 3e-6/(sigma sqrt(e)) of the peak, 5e-5 at
// 2 degrees. 1024 points against 2048 differ by less than 1e-5 of the peak (below).
TEST(deon2011_azimuth, density_of_circles_is_that_of_the_oracle) {
  const auto rows = test::reference_rows("azimuthal.csv");
  ASSERT_FALSE(rows.empty());
  const OffsetQuadrature quadrature(1024);
  AzimuthalTrace trace;
  double largest = 0;
  int compared = 0;
  for (const auto& row : rows) {
    if (std::stod(row[2]) != 1) continue;
    const double sigma = std::stod(row[5]) * degree, phi_i = std::stod(row[4]);
    const CircularFiber fiber{std::stof(row[1]), glm::vec3(std::stof(row[6])), splat(float(sigma))};
    const int p = std::stoi(row[7]);
    trace.trace(quadrature, fiber, float(std::stod(row[3]) * degree));
    double peak = 0, worst = 0;
    for (std::size_t k = 0; k < 360; ++k) {
      const double expected = std::stod(row[10 + k]);
      const double phi = std::remainder(double(k) - 180 - phi_i, 360.0) * degree;
      peak = std::max(peak, expected);
      worst = std::max(worst, std::abs(density(trace, p, phi) - expected));
    }
    EXPECT_LE(worst, 5e-5 * (2 * degree / sigma) * peak + 1e-5 * peak + 1e-7) << "row " << row[0] << " lobe " << row[8];
    largest = std::max(largest, worst / peak);
    ++compared;
  }
  EXPECT_GE(compared, 16);  // four circles, four lobes each
  std::printf("%d densities, largest error %.2g of the peak\n", compared, largest);
}

// columns: id, eta, e, theta_d, phi_i, sigma_a, E0..E6, E_rest, absorbed. Floats: sums of 256 groups, some 3e-6.
TEST(deon2011_azimuth, energies_of_circles_are_those_of_the_oracle) {
  const auto rows = test::reference_rows("energy.csv");
  ASSERT_FALSE(rows.empty());
  const OffsetQuadrature quadrature(512);
  double largest = 0;
  int compared = 0;
  for (const auto& row : rows) {
    if (std::stod(row[2]) != 1) continue;
    const CircularFiber fiber{std::stof(row[1]), glm::vec3(std::stof(row[5])), splat(0.1f)};
    const auto energies = fiber::circle_energies(quadrature, fiber, float(std::stod(row[3]) * degree));
    double rest = 0;
    for (std::size_t p = 4; p <= 7; ++p) rest += std::stod(row[6 + p]);
    for (std::size_t p = 0; p < 5; ++p) {
      const double error = std::abs(double(energies[p].g) - (p < 4 ? std::stod(row[6 + p]) : rest));
      EXPECT_LE(error, p < 4 ? 5e-6 : 1.5e-5) << "row " << row[0] << " order " << p;  // their rest is good to 1e-5
      largest = std::max(largest, error);
    }
    ++compared;
  }
  EXPECT_GT(compared, 10);
  std::printf("%d rows, largest error %.2g\n", compared, largest);
}

TEST(deon2011_azimuth, energies_of_clear_circles_sum_to_1_with_any_number_of_points) {
  for (const int points : {1, 2, 3, 10, 35, 70, 100, 4097}) {
    const OffsetQuadrature quadrature(points);
    for (const float eta : {1.05f, 1.55f, 3.0f}) {
      for (const double theta : {0.0, 30.0, 60.0, 80.0, 88.0, 89.99, 90.0}) {
        const CircularFiber fiber{eta, glm::vec3(0), splat(0.1f)};
        double sum = 0;
        for (const glm::vec3& energy : fiber::circle_energies(quadrature, fiber, float(theta * degree))) {
          EXPECT_GE(energy.g, 0);
          sum += double(energy.g);
        }
        EXPECT_NEAR(sum, 1, 1e-5) << points << " points, eta " << eta << ", theta_d " << theta;
      }
    }
  }
}

// Shapes have mass 1 by construction: midpoints of 0.02 rad or less resolve a blur of 0.025 to e^-30.
TEST(deon2011_azimuth, shapes_have_mass_1) {
  AzimuthalTrace trace;
  for (const int points : {1, 10, 35}) {
    const OffsetQuadrature quadrature(points);
    for (const float sigma : {0.025f, 0.3f, 0.56f, 0.785398f}) {
      trace.trace(quadrature, {1.55f, {0.0f, 0.5f, 400.0f}, splat(sigma)}, 0.7f);
      for (int p = 0; p < fiber::detected_orders; ++p) {
        glm::dvec3 mass(0);
        constexpr int steps = 400;
        for (int k = 0; k < steps; ++k) {
          mass += glm::dvec3(trace.shape(p, float(2 * pi * (k + 0.5) / steps - pi))) * (2 * pi / steps);
        }
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(mass[c], 1, 5e-6) << points << ' ' << sigma << ' ' << p;
      }
    }
  }
}

int count_peaks(const std::vector<double>& curve) {
  const double highest = *std::max_element(curve.begin(), curve.end());
  int peaks = 0;
  for (std::size_t k = 1; k + 1 < curve.size(); ++k) {
    peaks += curve[k] > curve[k - 1] && curve[k] >= curve[k + 1] && curve[k] > 0.01 * highest ? 1 : 0;
  }
  return peaks;
}

// Figure 8 of the paper of 2015: ten points and a narrow detector make spikes, one a node; a hundred make the curve.
TEST(deon2011_azimuth, ten_points_make_spikes_where_a_hundred_do_not) {
  const auto curve_of = [](int points, double sigma_deg, int p) {
    const OffsetQuadrature quadrature(points);
    AzimuthalTrace trace;
    trace.trace(quadrature, {1.55f, glm::vec3(0), splat(float(sigma_deg * degree))}, 0.3f);
    std::vector<double> curve;
    for (int k = 0; k < 1440; ++k) curve.push_back(density(trace, p, (k / 4.0 - 180) * degree));
    return curve;
  };
  const auto distance = [](const std::vector<double>& a, const std::vector<double>& b) {
    double difference = 0, whole = 0;
    for (std::size_t k = 0; k < a.size(); ++k) {
      difference += (a[k] - b[k]) * (a[k] - b[k]);
      whole += b[k] * b[k];
    }
    return std::sqrt(difference / whole);
  };
  for (const int p : {1, 2}) {
    for (const double sigma : {2.0, 5.0, 10.0, 20.0}) {
      const auto truth = curve_of(2000, sigma, p);
      std::printf(
          "%s, blur %4.1f degrees: relative L2 of 10, 35, 100 points = %.2g, %.2g, %.2g; peaks %d, %d, %d of %d\n",
          p == 1 ? "TT" : "TRT", sigma, distance(curve_of(10, sigma, p), truth),
          distance(curve_of(35, sigma, p), truth), distance(curve_of(100, sigma, p), truth),
          count_peaks(curve_of(10, sigma, p)), count_peaks(curve_of(35, sigma, p)),
          count_peaks(curve_of(100, sigma, p)), count_peaks(truth));
    }
  }
  // TT's exits are monotonous in h: a spike for each of the ten. The errors are far above those that resolved curves
  // have.
  EXPECT_EQ(count_peaks(curve_of(10, 2, 1)), 10);
  EXPECT_EQ(count_peaks(curve_of(10, 5, 1)), 10);
  EXPECT_GT(distance(curve_of(10, 2, 1), curve_of(2000, 2, 1)), 0.5);
  EXPECT_GT(distance(curve_of(10, 2, 2), curve_of(2000, 2, 2)), 0.2);
  for (const int p : {1, 2}) {
    EXPECT_EQ(count_peaks(curve_of(100, 2, p)), count_peaks(curve_of(2000, 2, p)));
    EXPECT_LT(distance(curve_of(100, 2, p), curve_of(2000, 2, p)), 1e-3);
    EXPECT_LT(distance(curve_of(10, 20, p), curve_of(2000, 20, p)), 0.05);  // wide Gaussians overlap
  }
}

}  // namespace
}  // namespace tress
