// Whether the samples of a model follow the density that it returns: chi-square on the assembled whole.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <vector>

#include "fiber/longitudinal.h"
#include "support/chi_square.h"
#include "tress/base/random.h"
#include "tress/fiber/fiber_model.h"

namespace tress::test {

/// p-value of `samples` over 36 x 36 bins against the integral of evaluate().pdf by midpoints: theta_points a bin of 5
/// degrees in theta, phi_points a bin of 10 in phi. The integral over all directions is expected to be 1 within
/// 2e-3; sample() must return the pdf of evaluate().
inline double density_p_value(const fiber::FiberModel& model, const fiber::FiberEvent& event, std::uint64_t seed,
                              int samples = 20000, int theta_points = 8, int phi_points = 8) {
  constexpr int bins = 36;
  constexpr double pi = std::numbers::pi, theta_step = pi / bins, phi_step = 2 * theta_step;
  std::vector<double> counts(bins * bins), expected(bins * bins);
  RandomStream random(seed);
  for (int i = 0; i < samples; ++i) {
    const fiber::FiberSample sample = model.sample(event, {random.next(), random.next(), random.next(), random.next()});
    if (i < 100) {
      EXPECT_FLOAT_EQ(sample.value.pdf, model.evaluate(event, sample.wi).pdf);
    }
    const int t = std::clamp(static_cast<int>((static_cast<double>(sample.wi.theta) / pi + 0.5) * bins), 0, bins - 1);
    const int p = std::clamp(static_cast<int>((static_cast<double>(sample.wi.phi) / pi + 1) * 0.5 * bins), 0, bins - 1);
    ++counts[static_cast<std::size_t>(t * bins + p)];
  }
  for (int t = 0; t < bins * theta_points; ++t) {
    const auto theta = static_cast<float>(-0.5 * pi + (t + 0.5) * theta_step / theta_points);
    for (int p = 0; p < bins * phi_points; ++p) {
      const auto phi = static_cast<float>(-pi + (p + 0.5) * phi_step / phi_points);
      expected[static_cast<std::size_t>(t / theta_points * bins + p / phi_points)] +=
          static_cast<double>(model.evaluate(event, {theta, phi}).pdf) * samples * theta_step / theta_points *
          phi_step / phi_points;
    }
  }
  EXPECT_NEAR(std::accumulate(expected.begin(), expected.end(), 0.0) / samples, 1, 2e-3);
  return chi_square(counts, expected).p_value;
}

}  // namespace tress::test
