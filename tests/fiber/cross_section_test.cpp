#include "fiber/cross_section.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "fiber/reference_data.h"

namespace {

using namespace tress;
using test::degree;

TEST(CrossSection, EnergiesAgreeWithReference) {
  const auto rows = test::reference_rows("energy.csv");
  ASSERT_FALSE(rows.empty());
  // Tolerances of the table at 8192 midpoints: E 5e-5, TIR 1e-3, rest 1e-4, closure 1e-6.
  constexpr int n = 8192;
  for (const auto& row : rows) {
    const fiber::CrossSection section(std::stod(row[1]), std::stod(row[2]), std::stod(row[4]) * degree,
                                      std::stod(row[3]) * degree);
    const double sigma_a = std::stod(row[5]);
    std::array<double, 7> energy{};
    std::array<int, 7> exits{};
    double rest = 0, absorbed = 0;
    for (int i = 0; i < n; ++i) {
      double path;
      const double left = section.follow((2 * i + 1.0) / n - 1, 300, 1e-6, &path,
                                         [&](int order, double weight, double, double, double length) {
                                           const double out = weight * std::exp(-sigma_a * length) / n;
                                           (order < 7 ? energy[std::size_t(order)] : rest) += out;
                                           if (order < 7) ++exits[std::size_t(order)];
                                           absorbed += weight / n - out;
                                         });
      const double out = left * std::exp(-sigma_a * path) / n;
      rest += out;
      absorbed += left / n - out;
    }
    double sum = rest + absorbed;
    for (std::size_t p = 0; p < 7; ++p) {
      EXPECT_NEAR(energy[p], std::stod(row[6 + p]), 5e-5) << "row " << row[0] << " E" << p;
      sum += energy[p];
      // Rays that died out early (1e-6) are counted as barred: only the first orders can be compared by count.
      if (p >= 1 && p <= 3) {
        EXPECT_NEAR(1 - double(exits[p]) / n, std::stod(row[14 + p]), 1e-3) << "row " << row[0] << " TIR" << p;
      }
    }
    EXPECT_NEAR(rest, std::stod(row[13]), 1e-4) << "row " << row[0];
    EXPECT_NEAR(absorbed, std::stod(row[14]), 1e-4) << "row " << row[0];
    EXPECT_NEAR(sum, 1, 1e-6) << "row " << row[0];
  }
}

TEST(CrossSection, TotalReflectionAtTheExitIsRealForEllipses) {
  // The design's measure: at e = 0.85 it bars 3 % of TRT at theta_d 0, 28 % at 60 degrees, 75 % at 80. A circle never.
  const auto barred = [](double e, double theta_d) {
    int count = 0, total = 0;
    for (int k = 0; k < 90; ++k) {
      const fiber::CrossSection section(1.55, e, k * degree, theta_d * degree);
      for (int i = 0; i < 256; ++i, ++total) {
        fiber::TracedOffset offset;
        section.trace((2 * i + 1) / 256.0 - 1, 2, &offset);
        count += offset.weight[2] == 0;
      }
    }
    return double(count) / total;
  };
  EXPECT_EQ(barred(1, 0), 0);
  EXPECT_EQ(barred(1, 80), 0);
  EXPECT_NEAR(barred(0.85, 0), 0.03, 0.01);
  EXPECT_NEAR(barred(0.85, 60), 0.28, 0.02);
  EXPECT_NEAR(barred(0.85, 80), 0.75, 0.02);
}

TEST(CrossSection, ResidualIsWhatIsLeftInside) {
  for (double e : {0.5, 0.85, 1.0}) {
    for (double theta : {0.0, 0.7, 1.4}) {
      const fiber::CrossSection section(1.55, e, 0.4, theta);
      for (double h : {-0.95, -0.3, 0.01, 0.8}) {
        fiber::TracedOffset offset;
        section.trace(h, 3, &offset);
        double residual = 0, shortest = 1e9;
        section.trace_residual(h, [&](double weight, double path) {
          residual += weight;
          if (weight > 0) shortest = std::min(shortest, path);
        });
        EXPECT_NEAR(residual, offset.remaining, 1e-12);
        if (residual > 0) {
          EXPECT_GT(shortest, offset.remaining_path);
        }
      }
    }
  }
}

TEST(CrossSection, GlintIsTheShareByTheRateOfTheExit) {
  // Against central differences of the traced exits, step 1e-6: their error is 1e-12 times the third derivative, 1e-9
  // by rounding; of a share of slope 1/2 in ln(rate) a few 1e-5 near the edges, where the derivatives explode.
  const double sigma = 0.15, step = 1e-6;
  int compared = 0;
  for (double e : {0.5, 0.85, 1.0}) {
    for (double theta : {0.0, 0.7, 1.3}) {
      for (double phi_r : {0.0, 0.4, 1.5, -2.0}) {
        const fiber::CrossSection section(1.55, e, phi_r, theta);
        for (double h = -0.97; h < 0.98; h += 0.05) {
          fiber::TracedOffset here, below, above;
          section.trace(h, 2, &here);
          section.trace(h - step, 2, &below);
          section.trace(h + step, 2, &above);
          const double share = section.glint_share(h, sigma);
          if (here.weight[2] == 0) {
            EXPECT_EQ(share, 0);
            continue;
          }
          if (below.weight[2] == 0 || above.weight[2] == 0) continue;
          const double turn = std::remainder(above.azimuth[2] - below.azimuth[2], 2 * std::numbers::pi);
          const double steep = turn / (2 * step) / (4 * sigma);
          EXPECT_NEAR(share, 1 / (1 + steep * steep), 1e-4) << e << ' ' << theta << ' ' << phi_r << ' ' << h;
          ++compared;
        }
        EXPECT_LT(section.glint_share(1, sigma), 1e-9);
        EXPECT_LT(section.glint_share(-1, sigma), 1e-9);
      }
    }
  }
  EXPECT_GT(compared, 700);
}

TEST(CrossSection, CircleHasTheClassicExitAngles) {
  // Marschner 2003, eq. 2: Phi_p = 2 p gamma_t - 2 gamma_i + p pi, here relative to phi_r, orientation reversed.
  for (double theta : {0.0, 0.8}) {
    const double phi_r = 0.3;
    const fiber::CrossSection section(1.55, 1, phi_r, theta);
    for (double h : {-0.9, -0.4, 0.2, 0.7}) {
      fiber::TracedOffset offset;
      section.trace(h, 3, &offset);
      const double gamma_i = std::asin(h), gamma_t = std::asin(h / section.eta_prime);
      for (int p = 0; p < 4; ++p) {
        const double expected = phi_r - (2 * p * gamma_t - 2 * gamma_i + p * std::numbers::pi);
        EXPECT_NEAR(std::remainder(offset.azimuth[p] - expected, 2 * std::numbers::pi), 0, 1e-12) << p;
        EXPECT_NEAR(offset.path[p], p * 2 * std::cos(gamma_t) / section.cos_theta_t, 1e-12) << p;
      }
    }
  }
}

TEST(CrossSection, StaysFiniteAtTheEdges) {
  for (double e : {0.5, 0.85, 1.0}) {
    for (double eta : {1.05, 1.55, 3.0}) {
      for (double theta : {0.0, 1.5, std::numbers::pi / 2, -std::numbers::pi / 2}) {
        for (double phi : {0.0, 0.7, std::numbers::pi / 2, -3.0}) {
          const fiber::CrossSection section(eta, e, phi, theta);
          for (double h : {-1.0, -1 + 1e-15, 0.0, 0.5, 1.0}) {
            double path, sum = 0;
            const double left =
                section.follow(h, 300, 1e-7, &path, [&](int, double weight, double x, double y, double l) {
                  EXPECT_GE(weight, 0);
                  // Refraction takes cos_t from 1 - eta'^2 sin^2: rounding grows with eta'^2, 1e12 at 90 degrees.
                  EXPECT_NEAR(std::hypot(x, y), 1, 1e-12 + 1e-14 * section.eta_prime * section.eta_prime);
                  EXPECT_TRUE(std::isfinite(l));
                  sum += weight;
                });
            EXPECT_NEAR(sum + left, 1, 1e-12);
            EXPECT_TRUE(std::isfinite(path));
          }
        }
      }
    }
  }
}

}  // namespace
