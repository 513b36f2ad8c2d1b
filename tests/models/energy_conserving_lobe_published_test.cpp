// The energy-conserving longitudinal lobe against its published form in doubles, and what its variance is one of.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "models/lobes/energy_conserving_lobe.h"
#include "support/quadrature.h"

namespace tress {
namespace {

using fiber::EnergyConservingLobe;
using fiber::half_pi;

constexpr double pi = std::numbers::pi;
constexpr double degree = pi / 180;

double bessel_i0(double x) { return std::cyl_bessel_i(0.0, x); }

// The published form, in doubles, where it does not overflow. Floats: the exponent -2 sin^2(x/2)/v <= 87 is good to
// 3e-7 of itself, so 3e-5 far out, where the density is nothing; 1e-5 of the peak holds all of it.
TEST(energy_conserving_lobe, density_is_the_published_form) {
  for (const double v : {0.01, 0.05, 0.2, 1.0, 8.0}) {
    for (const double theta_r : {0.0, 0.6, -1.4, 1.57}) {
      for (const double tilt : {-0.1, 0.0, 0.3}) {
        const EnergyConservingLobe lobe{float(theta_r), float(tilt), float(v)};
        const double cone = 2 * tilt - theta_r;
        const auto published = [&](double theta) {
          return std::cos(theta) / (2 * v * std::sinh(1 / v)) * std::exp(std::sin(theta) * std::sin(cone) / v) *
                 bessel_i0(std::cos(theta) * std::abs(std::cos(cone)) / v);
        };
        double peak = 0;
        for (double theta = -1.57; theta < 1.57; theta += 0.01) peak = std::max(peak, published(theta));
        for (double theta = -1.57; theta < 1.57; theta += 0.01) {
          ASSERT_NEAR(lobe.density(float(theta)), published(double(float(theta))), 1e-5 * peak)
              << v << ' ' << theta_r << ' ' << tilt;
        }
      }
    }
  }
}

// What v is: the variance of theta_i about the cone. At theta_r = 0 the law's tangent plane gives v (1 + O(v)).
TEST(energy_conserving_lobe, variance_is_that_of_theta_i_in_the_limit_of_narrow_lobes) {
  for (const double lambda_deg : {0.5, 1.0, 2.0, 4.0, 8.0, 16.0}) {
    const double lambda = lambda_deg * degree, v = 4 * pi * pi / 3 * lambda * lambda;
    const EnergyConservingLobe lobe(0, 0, float(v));
    const double variance = test::integrate([&](double t) { return t * t * double(lobe.density(float(t))); },
                                            -double(half_pi), double(half_pi), 160);
    const double of_logistic = 2 * pi * lambda / std::sqrt(3.0);  // in theta_i, not truncated
    std::printf("lambda %4.1f degrees: standard deviation of theta_i / that of the logistic = %.4f\n", lambda_deg,
                std::sqrt(variance) / of_logistic);
    EXPECT_NEAR(variance / v, 1, 0.6 * v + 1e-4) << lambda_deg;
    EXPECT_NEAR(of_logistic * of_logistic, v, 1e-12);
  }
}

}  // namespace
}  // namespace tress
