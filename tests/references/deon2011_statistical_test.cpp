// Samples of d'Eon et al. 2011 against its density, spikes included. Seeds are fixed; each family's false-alarm rate is
// 1e-4.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <iterator>
#include <memory>
#include <numbers>
#include <numeric>
#include <vector>

#include "fiber/longitudinal.h"
#include "models/lobes/energy_conserving_lobe.h"
#include "references/models/deon2011.h"
#include "support/chi_square.h"
#include "support/quadrature.h"
#include "support/seed.h"
#include "tress/base/random.h"

namespace tress {
namespace {

using fiber::FiberDirection;
using fiber::FiberEvent;
using fiber::FiberModel;
using fiber::FiberParameters;

constexpr float pi = std::numbers::pi_v<float>;
constexpr float degree = pi / 180;
constexpr double family_level = 1e-4;

struct Case {
  int points;
  float e, roughness, tilt_deg, theta_deg, phi_deg;
  float sigma_deg = 0;  ///< of TT, TRT, TRRT; 0: from the roughness
};

constexpr Case cases[] = {
    {70, 1.00f, 0.20f, 3, 0, 0},     {10, 0.85f, 0.20f, 3, 40, 130, 2}, {10, 0.70f, 0.10f, 3, 89, 40, 5},
    {35, 0.50f, 0.50f, 0, 70, -95},  {1, 1.00f, 0.20f, 3, -60, 10, 5},  {70, 1.00f, 1.00f, 15, 80, -170},
    {100, 0.85f, 0.05f, 3, -85, 90},
};

FiberParameters parameters_of(const Case& c) {
  FiberParameters parameters;
  parameters.eccentricity = c.e;
  parameters.roughness = c.roughness;
  parameters.tilt = c.tilt_deg * degree;
  if (c.sigma_deg > 0) parameters.azimuthal_sigma.fill(c.sigma_deg * degree);
  return parameters;
}

std::unique_ptr<FiberModel> model_of(int points) {
  fiber::ModelSettings settings;
  settings.quadrature_points = points;
  return fiber::make_deon2011(settings);
}

// Counts over 36 x 36 bins against the integral of pdf over each: midpoints, 12 a bin of 0.087 rad in theta_i (lobes of
// standard deviation 0.035 and more) and 16 of 0.011 rad in azimuth (blur of 0.025 and more).
double p_value_of(const FiberModel& model, const FiberEvent& event, std::uint64_t seed) {
  constexpr int bins = 36, samples = 30000, thetas = 12, azimuths = 16;
  std::vector<double> counts(bins * bins), expected(bins * bins);
  RandomStream random(seed);
  for (int i = 0; i < samples; ++i) {
    const FiberDirection wi = model.sample(event, {random.next(), random.next(), random.next(), random.next()}).wi;
    const int t = std::clamp(static_cast<int>((wi.theta / pi + 0.5f) * bins), 0, bins - 1);
    const int p = std::clamp(static_cast<int>((wi.phi / pi + 1) * 0.5f * bins), 0, bins - 1);
    ++counts[static_cast<std::size_t>(t * bins + p)];
  }
  const float theta_step = pi / (bins * thetas), phi_step = 2 * pi / (bins * azimuths);
  for (int t = 0; t < bins * thetas; ++t) {
    const float theta = (static_cast<float>(t) + 0.5f) * theta_step - 0.5f * pi;
    for (int p = 0; p < bins * azimuths; ++p) {
      const float pdf = model.evaluate(event, {theta, (static_cast<float>(p) + 0.5f) * phi_step - pi}).pdf;
      expected[static_cast<std::size_t>((t / thetas) * bins + p / azimuths)] +=
          static_cast<double>(pdf * theta_step * phi_step) * samples;
    }
  }
  EXPECT_NEAR(std::accumulate(expected.begin(), expected.end(), 0.0) / samples, 1, 2e-3);
  return test::chi_square(counts, expected).p_value;
}

TEST(deon2011_statistics, samples_follow_the_density) {
  double smallest = 1;
  std::uint64_t seed = test::seed(11);
  for (const Case& c : cases) {
    const auto model = model_of(c.points);
    const fiber::FiberId id = model->add_fiber(parameters_of(c));
    const FiberEvent event = model->begin(id, {c.theta_deg * degree, c.phi_deg * degree}, 0, 0, 0);
    const double p = p_value_of(*model, event, seed++);
    EXPECT_GT(p, test::sidak_level(family_level, std::size(cases)))
        << c.points << " points, roughness " << c.roughness << ", theta_r " << c.theta_deg;
    smallest = std::min(smallest, p);
  }
  std::printf("smallest p value of %zu: %.3g\n", std::size(cases), smallest);
}

// One lobe at a time: the gains of all others are 0.
TEST(deon2011_statistics, samples_of_every_lobe_alone_follow_its_density) {
  constexpr Case places[] = {cases[1], cases[3]};
  constexpr std::size_t lobes = 5, family = std::size(places) * lobes;
  double smallest = 1;
  std::uint64_t seed = test::seed(111);
  for (const Case& c : places) {
    const auto model = model_of(c.points);
    for (std::size_t lobe = 0; lobe < lobes; ++lobe) {
      FiberParameters parameters = parameters_of(c);
      parameters.gain.fill(glm::vec3(0));
      parameters.gain[lobe] = glm::vec3(1);
      const fiber::FiberId id = model->add_fiber(parameters);
      const FiberEvent event = model->begin(id, {c.theta_deg * degree, c.phi_deg * degree}, 0, 0, 0);
      ASSERT_NEAR(event.selection[lobe], 1, 1e-6f);
      const double p = p_value_of(*model, event, seed++);
      EXPECT_GT(p, test::sidak_level(family_level, family))
          << fiber::lobe_names[lobe] << ", " << c.points << " points, theta_r " << c.theta_deg;
      smallest = std::min(smallest, p);
    }
  }
  std::printf("smallest p value of %zu: %.3g\n", family, smallest);
}

// The largest gain makes samples choose a channel with hardly any light.
TEST(deon2011_statistics, samples_follow_the_density_where_channels_are_dark) {
  const auto model = model_of(10);
  FiberParameters parameters;
  parameters.sigma_a = {0.2f, 24.0f, 0.5f};
  parameters.gain[1] = {1.0f, 1e15f, 1.0f};
  const fiber::FiberId id = model->add_fiber(parameters);
  const FiberEvent event = model->begin(id, {0.2f, 1.0f}, 0, 0, 0);
  ASSERT_GT(event.energy[1].g, 0.01f);  // that of TT in green, which is 1e-15 or so without the gain
  const double p = p_value_of(*model, event, test::seed(211));
  EXPECT_GT(p, family_level);
}

// 4096 bins, pooled in the order of their expectation until each pool expects 1000 samples.
TEST(deon2011_statistics, inclinations_follow_their_lobe_from_the_narrowest_to_the_widest) {
  constexpr int bins = 64, samples = 64000;
  constexpr auto edge = static_cast<double>(fiber::half_pi);
  double smallest = 1;
  std::uint64_t seed = test::seed(311);
  constexpr double variances[] = {2.5e-4, 0.02, 0.5, 8.0};
  constexpr float knowns[] = {0.0f, -1.0f, 1.5f};
  for (const double v : variances) {
    for (const float theta_r : knowns) {
      const fiber::EnergyConservingLobe lobe(theta_r, 0.1f, static_cast<float>(v));
      constexpr int fine = 4096;
      std::vector<double> counts(fine), expected;
      RandomStream random(seed++);
      for (int i = 0; i < samples; ++i) {
        const double theta = static_cast<double>(lobe.sample(random.next(), random.next()));
        ++counts[static_cast<std::size_t>(std::clamp((theta / (2 * edge) + 0.5) * fine, 0.0, fine - 1.0))];
      }
      for (int k = 0; k < fine; ++k) {
        const double from = edge * (2.0 * k / fine - 1);
        expected.push_back(samples * test::integrate([&](double t) { return lobe.density(static_cast<float>(t)); },
                                                     from, from + 2 * edge / fine, 1));
      }
      const double p = test::chi_square(counts, expected, samples / bins).p_value;
      EXPECT_GT(p, test::sidak_level(family_level, 12)) << "v " << v << ", theta_r " << theta_r;
      smallest = std::min(smallest, p);
    }
  }
  std::printf("smallest p value of 12: %.3g\n", smallest);
}

}  // namespace
}  // namespace tress
