// The whole BCSDF over the whole range of its parameters: samples follow the density, the furnace is white, weights are
// bounded. Seeds are fixed; each family's false-alarm rate is 1e-4.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <iterator>
#include <numbers>
#include <numeric>
#include <vector>

#include "fiber/longitudinal.h"
#include "models/learned_model.h"
#include "support/chi_square.h"
#include "support/seed.h"

namespace tress {
namespace {

using fiber::Estimator;
using fiber::FiberDirection;
using fiber::FiberEvent;
using fiber::FiberParameters;
using fiber::FiberSample;
using test::LearnedModel;
using test::model_in;
using test::Rows;

constexpr float pi = std::numbers::pi_v<float>;
constexpr float degree = pi / 180;
constexpr double family_level = 1e-4;

struct Case {
  float e, roughness, tilt_deg, theta_deg, phi_deg;
  float sigma_deg = 0;  ///< of TT, TRT, TRRT; 0: from the roughness
};

// Every value of each parameter of the design's ranges, the extremes together.
constexpr Case cases[] = {
    {1.00f, 0.20f, 3, 0, 0},    {0.85f, 0.05f, 0, 40, 130},    {0.70f, 0.10f, 3, 89, 40, 5},
    {0.50f, 0.50f, 0, 70, -95}, {0.50f, 0.20f, 3, -60, 10, 2}, {0.70f, 0.05f, 0, 20, -170, 2},
    {0.85f, 0.50f, 3, -85, 90}, {1.00f, 0.10f, 0, 89, 77},
};

FiberParameters parameters_of(const Case& c) {
  FiberParameters parameters;
  parameters.eccentricity = c.e;
  parameters.roughness = c.roughness;
  parameters.tilt = c.tilt_deg * degree;
  if (c.sigma_deg > 0) parameters.azimuthal_sigma.fill(c.sigma_deg * degree);
  return parameters;
}

FiberDirection known_of(const Case& c) { return {c.theta_deg * degree, c.phi_deg * degree}; }

bool narrow(const Case& c) { return fiber::azimuthal_sigmas(parameters_of(c))[0] < 4 * degree; }

FiberSample draw(const LearnedModel& model, const FiberEvent& event, RandomStream& random) {
  return model.model().sample(event, {random.next(), random.next(), random.next(), random.next()});
}

// Counts over 36 x 36 bins against the integral of pdf over each. The rule resolves the narrowest lobe (theta_i of
// standard deviation 0.035, azimuth of 2 degrees): 12 points a bin of 0.087 rad in theta, 8 a bin of 0.17 rad in phi.
double p_value_of(const LearnedModel& model, const FiberEvent& event, std::uint64_t seed) {
  constexpr int bins = 36, samples = 20000;
  std::vector<double> counts(bins * bins), expected(bins * bins);
  RandomStream random(seed);
  for (int i = 0; i < samples; ++i) {
    const FiberDirection wi = draw(model, event, random).wi;
    const int t = std::clamp(static_cast<int>((wi.theta / pi + 0.5f) * bins), 0, bins - 1);
    const int p = std::clamp(static_cast<int>((wi.phi / pi + 1) * 0.5f * bins), 0, bins - 1);
    ++counts[static_cast<std::size_t>(t * bins + p)];
  }
  const double theta_step = static_cast<double>(pi) / bins, phi_step = 2 * theta_step;
  // theta outside, so that a trace of the vertex serves all azimuths
  for (int t = 0; t < bins; ++t) {
    for (int p = 0; p < bins; ++p) expected[static_cast<std::size_t>(t * bins + p)] = 0;
    const double theta_0 = -static_cast<double>(fiber::half_pi) + t * theta_step;
    constexpr int points = 12;  // midpoints in theta, 8 in phi
    for (int i = 0; i < points; ++i) {
      const auto theta = static_cast<float>(theta_0 + (i + 0.5) * theta_step / points);
      for (int j = 0; j < bins * 8; ++j) {
        const auto phi = static_cast<float>(-static_cast<double>(pi) + (j + 0.5) * phi_step / 8);
        const double pdf = static_cast<double>(model.model().evaluate(event, {theta, phi}).pdf);
        expected[static_cast<std::size_t>(t * bins + j / 8)] += pdf * samples * theta_step / points * phi_step / 8;
      }
    }
  }
  const double total = std::accumulate(expected.begin(), expected.end(), 0.0) / samples;
  EXPECT_NEAR(total, 1, 2e-3);
  return test::chi_square(counts, expected).p_value;
}

TEST(evidence, samples_follow_the_density_over_all_parameters_and_states) {
  const std::size_t whole_tests = std::size(cases) + static_cast<std::size_t>(std::ranges::count_if(
                                                         cases, [](const Case& c) { return !narrow(c); }));
  std::size_t tests = 0;
  double smallest = 1;
  for (const Case& c : cases) {
    for (const Rows rows : {Rows::open, Rows::converged}) {
      // Lobes under 4 degrees have no rows that answer: every event traces the vertex, and learning takes minutes.
      if (rows == Rows::converged && narrow(c)) continue;
      const auto model = model_in(rows, parameters_of(c), known_of(c));
      const double p = p_value_of(*model, model->begin(known_of(c)), test::seed(71 + tests++));
      EXPECT_GT(p, test::sidak_level(family_level, whole_tests))
          << test::name_of(rows) << " e " << c.e << " roughness " << c.roughness << " theta_r " << c.theta_deg;
      smallest = std::min(smallest, p);
    }
  }
  EXPECT_EQ(tests, whole_tests);
  std::printf("smallest p value of %zu: %.3g\n", tests, smallest);
}

// One lobe at a time: the gains of all others are 0, so that the whole density is that of the lobe.
TEST(evidence, samples_of_every_lobe_alone_follow_its_density) {
  constexpr Case places[] = {cases[0], cases[3], cases[6], {0.70f, 0.20f, 3, 35, 60, 5}};
  constexpr std::size_t family = std::size(places) * fiber::lobe_count * 2;
  std::size_t tests = 0;
  double smallest = 1;
  for (const Case& c : places) {
    for (std::size_t lobe = 0; lobe < fiber::lobe_count; ++lobe) {
      FiberParameters parameters = parameters_of(c);
      parameters.split_glint = true;
      parameters.gain.fill(glm::vec3(0.0f));
      parameters.gain[lobe] = glm::vec3(1.0f);
      for (const Rows rows : {Rows::open, Rows::converged}) {
        const auto model = model_in(rows, parameters, known_of(c));
        const double p = p_value_of(*model, model->begin(known_of(c)), test::seed(171 + tests++));
        EXPECT_GT(p, test::sidak_level(family_level, family))
            << fiber::lobe_names[lobe] << ' ' << test::name_of(rows) << " e " << c.e << " theta_r " << c.theta_deg;
        smallest = std::min(smallest, p);
      }
    }
  }
  EXPECT_EQ(tests, family);
  std::printf("smallest p value of %zu: %.3g\n", tests, smallest);
}

TEST(evidence, samples_of_exact_follow_its_density_over_all_parameters) {
  double smallest = 1;
  std::uint64_t seed = test::seed(271);
  constexpr Case places[] = {cases[0], cases[3], cases[6]};  // a narrow blur takes a minute
  for (const Case& c : places) {
    const auto model = model_in(Rows::traced_at_vertex, parameters_of(c), known_of(c));
    const double p = p_value_of(*model, model->begin(known_of(c)), seed++);
    EXPECT_GT(p, test::sidak_level(family_level, std::size(places))) << "e " << c.e << " theta_r " << c.theta_deg;
    smallest = std::min(smallest, p);
  }
  std::printf("smallest p value of %zu: %.3g\n", std::size(places), smallest);
}

// Two ways of adding up the same densities: fitted takes all rows in lanes, corrected one after another. An exponent of
// a lobe is at most 87 and is rounded to 2^-24 of that, so that no term is off by more than 6e-6 of itself; the sums
// add 1e-6.
TEST(evidence, density_of_corrected_is_that_of_fitted_to_rounding) {
  for (const Case& c : {cases[0], cases[3]}) {
    const auto model = model_in(Rows::converged, parameters_of(c), known_of(c));
    const FiberEvent event = model->begin(known_of(c));
    RandomStream random(test::seed(13)), again(test::seed(13));
    std::vector<FiberSample> fitted;
    for (int i = 0; i < 500; ++i) fitted.push_back(draw(*model, event, random));
    model->read_by(Estimator::corrected);
    const FiberEvent corrected_event = model->begin(known_of(c));
    for (const FiberSample& before : fitted) {
      const FiberSample now = draw(*model, corrected_event, again);
      ASSERT_EQ(now.wi.theta, before.wi.theta);
      ASSERT_EQ(now.wi.phi, before.wi.phi);
      ASSERT_NEAR(now.value.pdf, before.value.pdf, 1e-5f * before.value.pdf);
      const fiber::FiberValue value = model->model().evaluate(corrected_event, now.wi);
      ASSERT_EQ(now.value.pdf, value.pdf);
      for (std::size_t p = 0; p < fiber::lobe_count; ++p) ASSERT_EQ(now.value.s[p], value.s[p]);
    }
  }
}

// Clear hair: the mean weight is the sum of the energies, 1 by construction but for the table's interpolation, within
// 0.2 % and 4.5 standard errors (false alarm 7e-6 each, 24 of them).
TEST(evidence, furnace_is_white_for_every_inclination_ellipse_and_azimuth) {
  double largest = 0;
  RandomStream place(test::seed(29));
  for (const float e : {1.0f, 0.85f, 0.7f, 0.5f}) {
    FiberParameters parameters;
    parameters.sigma_a = glm::vec3(0);
    parameters.eccentricity = e;
    const LearnedModel model(parameters, Estimator::fitted);
    for (const float theta : {0.0f, 30.0f, 60.0f, -75.0f, 85.0f, 89.0f}) {
      const FiberDirection known{theta * degree, 2 * pi * (place.next() - 0.5f)};
      test::SampleMean weight;
      RandomStream random(test::seed(43), static_cast<std::uint64_t>(theta + 90));
      const FiberEvent event = model.begin(known);
      for (int i = 0; i < 8000; ++i) {
        const FiberSample sample = draw(model, event, random);
        weight.add(static_cast<double>(sample.value.total().g / sample.value.pdf));
      }
      EXPECT_NEAR(weight.mean(), 1, 2e-3 + 4.5 * weight.standard_error()) << "e " << e << " theta_r " << theta;
      double energy = 0;
      for (const glm::vec3& lobe : event.energy) energy += static_cast<double>(lobe.g);
      EXPECT_NEAR(energy, 1, 2e-3);
      largest = std::max(largest, std::abs(weight.mean() - 1));
    }
  }
  std::printf("largest furnace error by sampling: %.4f\n", largest);
}

// Weights S/Q in luminance where all queries were answered by fits. R's own sampler has weight F/(E_R (...)) and rows
// at most 1/(1-u): below 2 together, as elliptical_model_test derives. `corrected` adds 16 (g - f): never below -15
// times the bound of f, never above 16 g/q, whose q is at least u/2 pi and whose g/E is at most 1/(sqrt(2 pi) sigma).
TEST(evidence, weights_stay_within_the_bound_of_each_estimator) {
  for (const Case& c : {cases[0], cases[3], cases[6]}) {
    const FiberParameters parameters = parameters_of(c);
    const auto model = model_in(Rows::converged, parameters, known_of(c));
    const auto sigmas = fiber::azimuthal_sigmas(parameters);
    const float sigma = *std::ranges::min_element(sigmas);
    const float highest = 16 * 2 * pi / 0.02f / (std::sqrt(2 * pi) * sigma);
    for (const Estimator estimator : {Estimator::fitted, Estimator::corrected, Estimator::exact}) {
      model->read_by(estimator);
      const FiberEvent event = model->begin(known_of(c));
      const int samples = estimator == Estimator::exact ? 3000 : 20000;
      float smallest = 0, largest = 0;
      RandomStream random(test::seed(53));
      for (int i = 0; i < samples; ++i) {
        const FiberSample sample = draw(*model, event, random);
        if (estimator == Estimator::fitted && sample.value.exact_queries > 0) continue;
        const glm::vec3 weight = sample.value.total() / sample.value.pdf;
        const float w = 0.2126f * weight.r + 0.7152f * weight.g + 0.0722f * weight.b;
        smallest = std::min(smallest, w);
        largest = std::max(largest, w);
      }
      std::printf("%s, e %.2f, roughness %.2f, theta_r %.0f: weights %.3f to %.3f\n", estimator_name(estimator),
                  static_cast<double>(c.e), static_cast<double>(c.roughness), static_cast<double>(c.theta_deg),
                  static_cast<double>(smallest), static_cast<double>(largest));
      EXPECT_GE(smallest, estimator == Estimator::corrected ? -30.0f : 0.0f);
      EXPECT_LE(largest, estimator == Estimator::corrected ? highest : 2.0f);
    }
  }
}

}  // namespace
}  // namespace tress
