// Samplers against their densities, and the furnace by sampling. Seeds are fixed; each family's false-alarm rate is
// 1e-4.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "fiber/lobe_widths.h"
#include "fiber/longitudinal.h"
#include "fiber/reflection.h"
#include "models/learned_model.h"
#include "support/chi_square.h"
#include "support/quadrature.h"
#include "support/seed.h"

namespace tress {
namespace {

using fiber::FiberDirection;
using fiber::FiberEvent;
using fiber::FiberParameters;
using fiber::FiberSample;
using test::LearnedModel;
using test::model_in;
using test::name_of;
using test::Rows;

constexpr float pi = std::numbers::pi_v<float>;
constexpr float degree = pi / 180;
constexpr double family_level = 1e-4;
constexpr int theta_bins = 24, phi_bins = 24;

// Expected counts of a density over theta_i x phi_i. At a fixed xi the shape jumps where theta_i changes the node: the
// rule's error there is far below the statistical one (256 points a bin row, counts of some hundred).
template <class Density>
std::vector<double> expected_counts(Density density, double samples) {
  std::vector<double> expected;
  for (int i = 0; i < theta_bins; ++i) {
    for (int j = 0; j < phi_bins; ++j) {
      const double theta = -fiber::half_pi + pi * i / theta_bins, phi = -pi + 2 * pi * j / phi_bins;
      expected.push_back(
          samples * test::integrate_2d(density, theta, theta + pi / theta_bins, phi, phi + 2 * pi / phi_bins, 2, 1));
    }
  }
  return expected;
}

std::size_t bin_of(const FiberDirection& wi) {
  const int i = std::clamp(static_cast<int>((wi.theta / pi + 0.5f) * theta_bins), 0, theta_bins - 1);
  const int j = std::clamp(static_cast<int>((wi.phi / pi + 1) * 0.5f * phi_bins), 0, phi_bins - 1);
  return static_cast<std::size_t>(i * phi_bins + j);
}

FiberSample draw(const LearnedModel& model, const FiberEvent& event, RandomStream& random) {
  return model.model().sample(event, {random.next(), random.next(), random.next(), random.next()});
}

TEST(elliptical_model_statistics, samples_follow_the_density_in_every_state_of_the_rows) {
  constexpr int samples = 20000;
  FiberParameters parameters;  // tilted and colored
  parameters.roughness = 0.3f;
  double smallest = 1;
  for (const FiberDirection known : {FiberDirection{0.3f, 0.7f}, FiberDirection{-83 * degree, -2.5f}}) {
    for (const Rows rows : {Rows::traced_at_vertex, Rows::absent, Rows::open, Rows::converged}) {
      const auto model = model_in(rows, parameters, known);
      const FiberEvent event = model->begin(known);
      std::vector<double> counts(theta_bins * phi_bins);
      RandomStream random(test::seed(17));
      for (int i = 0; i < samples; ++i) ++counts[bin_of(draw(*model, event, random).wi)];
      const auto expected = expected_counts(
          [&](double theta, double phi) {
            return model->model().evaluate(event, {static_cast<float>(theta), static_cast<float>(phi)}).pdf;
          },
          samples);
      const double p_value = test::chi_square(counts, expected).p_value;
      EXPECT_GT(p_value, test::sidak_level(family_level, 8)) << name_of(rows) << " theta_r " << known.theta;
      smallest = std::min(smallest, p_value);
    }
  }
  std::printf("smallest p value of 8: %.3g\n", smallest);
}

// Clear hair without an open row: q_p M_p = (1-u) S_p/E_p + u M_p/2 pi, so each lobe's own density is known.
TEST(elliptical_model_statistics, samples_of_each_lobe_follow_its_own_density) {
  constexpr int samples = 40000;
  FiberParameters parameters;
  parameters.sigma_a = glm::vec3(0);
  parameters.roughness = 0.3f;
  const FiberDirection known{0.5f, 0.7f};
  const fiber::LobeWidths::At widths = fiber::LobeWidths::as_traced(parameters).at(known.theta);
  for (const Rows rows : {Rows::absent, Rows::converged}) {
    const auto model = model_in(rows, parameters, known);
    const FiberEvent event = model->begin(known);
    const float u = rows == Rows::converged ? 0.02f : 0.05f;
    std::vector<std::vector<double>> counts(fiber::lobe_count, std::vector<double>(theta_bins * phi_bins));
    std::vector<double> drawn(fiber::lobe_count);
    RandomStream random(test::seed(23));
    for (int i = 0; i < samples; ++i) {
      const FiberSample sample = draw(*model, event, random);
      ++counts[static_cast<std::size_t>(sample.lobe)][bin_of(sample.wi)];
      ++drawn[static_cast<std::size_t>(sample.lobe)];
    }
    for (int p = 0; p < fiber::lobe_count; ++p) {
      const auto lobe = static_cast<std::size_t>(p);
      const double share = event.selection[lobe];
      if (!(share > 0)) {
        EXPECT_EQ(drawn[lobe], 0);
        continue;
      }
      EXPECT_GT(test::z_test(drawn[lobe], samples * share, std::sqrt(samples * share * (1 - share))),
                test::sidak_level(family_level, 20));
      const int lane = fiber::LobeWidths::lane_of(std::min(p, 3));  // the residual has TRRT's
      const float lambda = widths.lambda[lane];
      const fiber::LongitudinalLobe m(known.theta, widths.tilt[lane] + widths.shift[lane], lambda);
      const fiber::ReflectionLobe r(parameters.eta, parameters.eccentricity, known.theta, known.phi, event.energy[0].r,
                                    widths.tilt[lane], lambda);
      const auto expected = expected_counts(
          [&](double theta, double phi) -> double {
            const FiberDirection wi{static_cast<float>(theta), static_cast<float>(phi)};
            if (p == 0) return r.azimuth_pdf(wi.phi) * r.longitudinal(wi.phi).density(wi.theta);
            if (p == 4) return m.density(wi.theta) / (2 * pi);
            const float s = model->model().evaluate(event, wi).s[lobe].g / event.energy[lobe].g;
            return (1 - u) * s + u * m.density(wi.theta) / (2 * pi);
          },
          drawn[lobe]);
      const double p_value = test::chi_square(counts[lobe], expected).p_value;
      EXPECT_GT(p_value, test::sidak_level(family_level, 20)) << name_of(rows) << " lobe " << p;
      std::printf("%s lobe %d: p value %.3g\n", name_of(rows), p, p_value);
    }
  }
}

// The mean weight of the sampler in clear hair is the energy: within 0.2 % (energy table) and 4.5 standard errors
// (false alarm 7e-6 each, 18 of them).
TEST(elliptical_model_statistics, white_furnace_is_one_by_sampling) {
  for (const float e : {1.0f, 0.85f, 0.7f}) {
    FiberParameters parameters;
    parameters.sigma_a = glm::vec3(0);
    parameters.eccentricity = e;
    LearnedModel model(parameters, false);
    for (const float theta : {0.0f, 20.0f, 40.0f, 60.0f, 75.0f, 85.0f}) {
      const FiberDirection known{theta * degree, 0.4f};
      model.teach(known, 6, 1500, 31, false);
      test::SampleMean mean;
      RandomStream random(test::seed(41), static_cast<std::uint64_t>(theta));
      for (int i = 0; i < 30000; ++i) {
        const float xi1 = random.next(), xi2 = random.next();
        const FiberSample sample = draw(model, model.begin(known, xi1, xi2), random);
        mean.add(sample.value.total().g / sample.value.pdf);
      }
      EXPECT_NEAR(mean.mean(), 1, 2e-3 + 4.5 * mean.standard_error()) << "e " << e << " theta_r " << theta;
      std::printf("e %.2f theta_r %2.0f: furnace %.5f +- %.5f\n", static_cast<double>(e), static_cast<double>(theta),
                  mean.mean(), mean.standard_error());
    }
  }
}

}  // namespace
}  // namespace tress
