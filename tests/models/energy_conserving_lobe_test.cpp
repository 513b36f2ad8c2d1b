// d'Eon's longitudinal lobe: mass 1 at every inclination, finite everywhere, as wide as asked.
#include "models/lobes/energy_conserving_lobe.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "support/quadrature.h"

namespace tress {
namespace {

using fiber::EnergyConservingLobe;

constexpr float degree = 0.0174532925f;

// 16 panels of 8 points between the marks 0, +-2, +-8, +-30 deviations about the mode: the rule is exact to 1e-7. What
// is left is the Bessel series (3e-7) and the rounding of theta_h over the narrowest lobe (6e-8 of an angle whose
// deviation is 0.016: 4e-6 of the mass): tolerance 1e-5.
TEST(energy_conserving_lobe, has_mass_one_for_every_inclination_width_and_tilt) {
  for (const float variance : {2.6e-4f, 0.01f, 0.3f, 2.0f, 12.0f}) {
    for (const float theta : {-90.0f, -89.9f, -60.0f, 0.0f, 35.0f, 80.0f, 89.0f, 90.0f}) {
      for (const float tilt : {-10.0f, 0.0f, 3.0f, 25.0f}) {
        const EnergyConservingLobe lobe(theta * degree, tilt * degree, variance);
        const double deviation = std::sqrt(double{variance}), pole = double{fiber::half_pi};
        const double turned = double{theta - 2 * tilt} * double{degree};
        const double mode = -std::asin(std::sin(turned));
        std::vector<double> marks{-pole, pole};
        for (const double k : {-30.0, -8.0, -2.0, 0.0, 2.0, 8.0, 30.0})
          marks.push_back(std::clamp(mode + k * deviation, -pole, pole));
        std::sort(marks.begin(), marks.end());
        double mass = 0;
        for (std::size_t i = 0; i + 1 < marks.size(); ++i)
          mass += test::integrate([&](double x) { return lobe.density(static_cast<float>(x)); }, marks[i], marks[i + 1],
                                  16);
        EXPECT_NEAR(mass, 1, 1e-5) << "variance " << variance << " theta " << theta << " tilt " << tilt;
      }
    }
  }
}

TEST(energy_conserving_lobe, is_about_the_tilted_cone_and_as_wide_as_the_logistic) {
  const float lambda = 0.02f, theta_r = 0.5f, tilt = -0.05f;
  const EnergyConservingLobe lobe(theta_r, tilt, EnergyConservingLobe::variance_of(lambda));
  const auto moment = [&](int k) {
    return test::integrate([&](double x) { return std::pow(x, k) * double{lobe.density(static_cast<float>(x))}; }, -1.5,
                           1.5, 64);
  };
  const double mean = moment(1), variance = moment(2) - mean * mean;
  // The publication's lobe is pulled towards the normal plane by about v/2 tan t; its variance in theta_i is v up to
  // terms of order v^2 (v = 0.0053).
  EXPECT_NEAR(mean, -(0.5 + 0.1), 0.005);
  EXPECT_NEAR(variance / EnergyConservingLobe::variance_of(lambda), 1, 0.03);
}

TEST(energy_conserving_lobe, samples_are_finite_and_of_positive_density) {
  const float below_one = 0x1.fffffep-1f;
  for (const float variance : {0.0f, 0.01f, 12.0f}) {
    for (const float theta : {-90.0f, 0.0f, 60.0f, 90.0f}) {
      const EnergyConservingLobe lobe(theta * degree, 0, variance);
      for (const float u : {0.0f, 1e-6f, 0.5f, below_one}) {
        for (const float v : {0.0f, 0.25f, 0.5f, below_one}) {
          const float x = lobe.sample(u, v);
          ASSERT_TRUE(std::isfinite(x) && std::abs(x) <= fiber::half_pi);
          ASSERT_GT(lobe.density(x), 0);
        }
      }
    }
  }
}

}  // namespace
}  // namespace tress
