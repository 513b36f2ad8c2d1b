// Chi-square of the longitudinal sampler. Seed 1; family false-alarm rate 1e-3, Sidak-corrected.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "fiber/longitudinal.h"
#include "support/chi_square.h"
#include "support/quadrature.h"
#include "support/scale.h"
#include "support/seed.h"
#include "tress/base/random.h"

namespace {

using namespace tress;
using fiber::half_pi;

TEST(LongitudinalSampling, FollowsItsDensity) {
  const float inclinations[] = {-half_pi, -1.2f, 0.0f, 0.5f, 1.55f};
  const float tilts[] = {-0.3f, 0.0f, 0.13f};
  const float scales[] = {fiber::smallest_lambda, 0.05f, 0.5f};
  constexpr int bins = 180;
  const int samples = test::scaled(100000);
  const double level = test::sidak_level(1e-3, 3 * 45);
  std::uint64_t stream = 0;
  for (int k = 0; k < 3 * 5; ++k) {
    const auto shape = static_cast<fiber::LongitudinalShape>(k / 5);
    const float theta_r = inclinations[k % 5];
    for (float tilt : tilts) {
      for (float lambda : scales) {
        const fiber::LongitudinalLobe lobe(theta_r, tilt, lambda, shape);
        RandomStream random(test::seed(1), ++stream);
        std::vector<double> counts(bins), expected(bins);
        const double width = 2.0 * half_pi / bins;
        for (int i = 0; i < samples; ++i) {
          const double bin = (lobe.sample(random.next()) + double(half_pi)) / width;
          ++counts[std::size_t(std::min(bin, bins - 1.0))];
        }
        double total = 0;
        for (int b = 0; b < bins; ++b) {
          const double from = -double(half_pi) + b * width;
          expected[std::size_t(b)] =
              test::integrate([&](double t) { return lobe.density(float(t)); }, from, from + width, 16);
          total += expected[std::size_t(b)];
        }
        for (double& x : expected) x *= samples / total;
        EXPECT_GT(test::chi_square(counts, expected).p_value, level)
            << int(shape) << ' ' << theta_r << ' ' << tilt << ' ' << lambda;
      }
    }
  }
}

}  // namespace
