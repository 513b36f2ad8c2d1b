// The sampler of R against its density, and its weights. Seed 2; family false-alarm rate 1e-3, Sidak-corrected.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fiber/direct_energies.h"
#include "fiber/reflection.h"
#include "support/chi_square.h"
#include "support/quadrature.h"
#include "support/scale.h"
#include "support/seed.h"
#include "tress/base/random.h"

namespace {

using namespace tress;
constexpr double pi = std::numbers::pi;

TEST(ReflectionSampling, FollowsItsDensityWithBoundedWeights) {
  constexpr int bins = 120;
  const int samples = test::scaled(100000);
  const double level = test::sidak_level(1e-3, 2 * 36);
  std::uint64_t stream = 0;
  double largest = 0, worst_variance = 0;
  for (float e : {0.5f, 0.85f, 1.0f}) {
    for (float theta : {0.0f, 0.8f, 1.5f}) {
      for (float phi_r : {0.0f, 0.6f, float(pi / 2), -2.2f}) {
        const float energy = test::direct_energies(1.55, e, glm::vec3(0), phi_r, theta, 8192, 0).clear[0];
        const fiber::ReflectionLobe lobe(1.55f, e, theta, phi_r, energy, 0, 0.1f);
        RandomStream random(test::seed(2), ++stream);
        std::vector<double> counts(bins), expected(bins);
        test::SampleMean weights;
        double squares = 0;
        for (int i = 0; i < samples; ++i) {
          const float phi = lobe.sample_azimuth(random.next());
          const double weight = lobe.energy_density(phi) / lobe.azimuth_pdf(phi) / energy;
          weights.add(weight);
          squares += weight * weight;
          largest = std::max(largest, weight);
          ++counts[std::size_t(std::min((phi + pi) / (2 * pi) * bins, bins - 1.0))];
        }
        worst_variance = std::max(worst_variance, squares / samples - 1);
        double total = 0;
        for (int b = 0; b < bins; ++b) {
          const double from = -pi + 2 * pi * b / bins;
          expected[std::size_t(b)] =
              test::integrate([&](double x) { return lobe.azimuth_pdf(float(x)); }, from, from + 2 * pi / bins, 16);
          total += expected[std::size_t(b)];
        }
        EXPECT_NEAR(total, 1, 1e-3);  // the pdf may jump within a bin, at the antipode of phi_r
        for (double& x : expected) x *= samples / total;
        EXPECT_GT(test::chi_square(counts, expected).p_value, level) << e << ' ' << theta << ' ' << phi_r;
        EXPECT_GT(test::z_test(weights.mean(), 1, weights.standard_error()), level)
            << e << ' ' << theta << ' ' << phi_r;
      }
    }
  }
  RecordProperty("largest_weight", std::to_string(largest));
  RecordProperty("largest_variance", std::to_string(worst_variance));
  // Drawing h uniformly alone gives weights up to 1/E_R, more than 10.
  EXPECT_LT(largest, 4);
}

}  // namespace
