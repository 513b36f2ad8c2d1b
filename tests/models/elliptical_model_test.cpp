// The assembled BCSDF: one density for sample, eval and pdf; mass 1; bounded weights; finite everywhere.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "fiber/fourier_reference.h"
#include "fiber/lobe_widths.h"
#include "fiber/longitudinal.h"
#include "models/learned_model.h"
#include "support/quadrature.h"

namespace tress {
namespace {

using fiber::FiberDirection;
using fiber::FiberEvent;
using fiber::FiberParameters;
using fiber::FiberSample;
using fiber::FiberValue;
using test::LearnedModel;
using test::model_in;
using test::name_of;
using test::Rows;

constexpr float pi = std::numbers::pi_v<float>;
constexpr float degree = pi / 180;
constexpr Rows all_rows[] = {Rows::traced_at_vertex, Rows::absent, Rows::open, Rows::converged};

FiberParameters clear_hair(float e = 0.85f) {
  FiberParameters parameters;
  parameters.eccentricity = e;
  parameters.sigma_a = glm::vec3(0);
  return parameters;
}

// Integral of f(value) over all directions: theta_i outside, so that a vertex trace serves a whole inner integral.
template <class Read>
double integral(const LearnedModel& model, const FiberEvent& event, Read read) {
  return test::integrate_2d(
      [&](double theta, double phi) {
        return read(model.model().evaluate(event, {static_cast<float>(theta), static_cast<float>(phi)}));
      },
      -fiber::half_pi, fiber::half_pi, -pi, pi, 24, 16);
}

TEST(elliptical_model, sample_and_evaluate_agree_to_the_bit) {
  const FiberDirection known{0.4f, 0.9f};
  for (const Rows rows : all_rows) {
    const auto model = model_in(rows, FiberParameters{}, known);
    RandomStream random(11);
    for (int i = 0; i < 300; ++i) {
      const FiberEvent event = i < 150 ? model->begin(known)
                                       : model->begin({pi * (random.next() - 0.5f), 2 * pi * (random.next() - 0.5f)},
                                                      random.next(), random.next());
      const FiberSample sample =
          model->model().sample(event, {random.next(), random.next(), random.next(), random.next()});
      const FiberValue again = model->model().evaluate(event, sample.wi);
      ASSERT_EQ(sample.value.pdf, again.pdf) << name_of(rows);
      for (std::size_t p = 0; p < fiber::lobe_count; ++p) ASSERT_EQ(sample.value.s[p], again.s[p]) << name_of(rows);
      ASSERT_EQ(sample.value.queries, again.queries);
      ASSERT_EQ(sample.value.objective, again.objective);
    }
  }
}

TEST(elliptical_model, every_input_gives_finite_values_and_a_positive_density) {
  const float edges[] = {-pi / 2, -89.95f * degree, -1.0f, 0.0f, 0.3f, 89.9f * degree, pi / 2};
  const float turns[] = {-pi, -pi / 2, -1.0f, 0.0f, pi / 2, pi, 7.0f};
  const float nearly_one = 0x1.fffffep-1f;
  FiberParameters dark = clear_hair(0.5f);
  dark.sigma_a = {0.5f, 50.0f, 1e4f};
  FiberParameters thin = clear_hair(0.7f);
  thin.roughness = 0.02f;
  for (const FiberParameters& parameters : {FiberParameters{}, clear_hair(1.0f), dark, thin}) {
    for (const bool exact : {false, true}) {
      const LearnedModel model(parameters, exact);
      for (const float theta : edges) {
        for (const float phi : turns) {
          const FiberEvent event = model.begin({theta, phi}, nearly_one, phi < 0 ? 0.0f : nearly_one);
          for (const float u : {0.0f, 0.31f, 0.9f, nearly_one}) {
            for (const float v : {0.0f, nearly_one}) {
              const FiberSample sample = model.model().sample(event, {u, v, 1 - v < u ? v : u, v});
              ASSERT_TRUE(std::isfinite(sample.wi.theta) && std::isfinite(sample.wi.phi));
              ASSERT_LE(std::fabs(sample.wi.theta), pi / 2);
              for (const FiberValue& value : {sample.value, model.model().evaluate(event, {theta, -phi})}) {
                ASSERT_TRUE(std::isfinite(value.pdf) && value.pdf > 0) << theta << " " << phi << " " << u << " " << v;
                for (const glm::vec3& s : value.s) {
                  for (int c = 0; c < 3; ++c) ASSERT_TRUE(std::isfinite(s[c]) && s[c] >= 0);
                }
              }
              if (exact) break;
            }
          }
        }
      }
    }
  }
}

// The rule resolves these widths to 1e-4 (24 x 16 panels against 48 x 32), except R's corners at its terminator:
// tolerance 2e-3.
TEST(elliptical_model, density_integrates_to_one_in_every_state_of_the_rows) {
  for (const FiberDirection known : {FiberDirection{0.3f, 0.7f}, FiberDirection{-1.2f, -2.5f}}) {
    for (const Rows rows : all_rows) {
      const auto model = model_in(rows, FiberParameters{}, known);
      const double mass =
          integral(*model, model->begin(known), [](const FiberValue& value) { return double{value.pdf}; });
      EXPECT_NEAR(mass, 1, 2e-3) << name_of(rows) << " theta_r " << known.theta;
    }
  }
}

// Energy table error 1.5e-3 at 99 % (the design's figure) on top of the quadrature's 5e-4: tolerance 2e-3.
TEST(elliptical_model, white_furnace_is_one_by_quadrature) {
  double largest = 0;
  for (const float e : {1.0f, 0.85f, 0.7f}) {
    for (const float theta : {0.0f, 30.0f, 60.0f, 75.0f, 85.0f}) {
      const FiberDirection known{theta * degree, 1.1f};
      const auto model = model_in(Rows::absent, clear_hair(e), known);
      const double mass =
          integral(*model, model->begin(known), [](const FiberValue& v) { return double{v.total().g}; });
      EXPECT_NEAR(mass, 1, 2e-3) << "e " << e << " theta_r " << theta;
      largest = std::max(largest, std::abs(mass - 1));
    }
  }
  RecordProperty("largest_error", std::to_string(largest));
  std::printf("largest furnace error by quadrature: %.5f\n", largest);
}

// Every law of M and every Fresnel of R: the sampler has mass 1, and S has the energies of the event. Tolerances as
// above.
TEST(elliptical_model, shapes_and_kinds_of_fresnel_keep_density_and_energy) {
  const auto expect_energies = [](const FiberParameters& parameters) {
    const FiberDirection known{0.9f, 0.7f};
    const auto model = model_in(Rows::absent, parameters, known);
    const FiberEvent event = model->begin(known);
    float energy = 0;
    for (const glm::vec3& lobe : event.energy) energy += lobe.g;
    EXPECT_NEAR(integral(*model, event, [](const FiberValue& v) { return double{v.total().g}; }), energy, 2e-3);
    EXPECT_NEAR(integral(*model, event, [](const FiberValue& v) { return double{v.pdf}; }), 1, 2e-3);
    return energy;
  };
  FiberParameters parameters = clear_hair();
  for (const auto shape : {fiber::LongitudinalShape::gaussian, fiber::LongitudinalShape::cauchy}) {
    parameters.longitudinal_shape = shape;
    EXPECT_NEAR(expect_energies(parameters), 1, 1e-5);
  }
  parameters = clear_hair();
  parameters.reflection_fresnel = fiber::ReflectionFresnel::bravais;
  EXPECT_NE(expect_energies(parameters), 1);
  parameters.reflection_fresnel = fiber::ReflectionFresnel::none;
  EXPECT_GT(expect_energies(parameters), 1.5);
}

TEST(elliptical_model, weights_of_rows_that_have_converged_are_bounded) {
  // The luminance of sum_p S_p over Q: rows give at most 1/(1-u) = 1.0204, R's own sampler at most 2 (b >= 1/2 only
  // where E_R is near 0), and the total of the energies is at most 1.
  for (const float e : {1.0f, 0.7f}) {
    for (const glm::vec3 sigma_a : {glm::vec3(0), glm::vec3(0.3f, 1.0f, 3.0f)}) {
      FiberParameters parameters = clear_hair(e);
      parameters.sigma_a = sigma_a;
      const FiberDirection known{0.5f, 0.8f};
      const auto model = model_in(Rows::converged, parameters, known);
      RandomStream random(3);
      float largest = 0;
      int exact = 0, rows_drawn = 0;
      for (int i = 0; i < 20000; ++i) {
        const FiberSample sample =
            model->model().sample(model->begin(known), {random.next(), random.next(), random.next(), random.next()});
        exact += sample.value.exact_queries;
        rows_drawn += sample.value.queries;
        const glm::vec3 weight = sample.value.total() / sample.value.pdf;
        if (sample.value.exact_queries == 0)
          largest = std::max(largest, 0.2126f * weight.x + 0.7152f * weight.y + 0.0722f * weight.z);
      }
      EXPECT_LT(largest, 2.0f);
      EXPECT_LT(exact, rows_drawn / 20);
      std::printf("e %.2f sigma_a %.1f: largest weight %.4f, %.2f %% of queries exact\n", static_cast<double>(e),
                  static_cast<double>(sigma_a.y), static_cast<double>(largest), 100.0 * exact / rows_drawn);
    }
  }
}

TEST(elliptical_model, objective_is_one_a_query_before_the_first_test_and_below_epsilon_once_converged) {
  const FiberDirection known{0.3f, 0.7f};
  for (const Rows rows : all_rows) {
    const auto model = model_in(rows, FiberParameters{}, known);
    const FiberEvent event = model->begin(known);
    RandomStream random(5);
    double objective = 0, queries = 0;
    for (int i = 0; i < 200; ++i) {
      const FiberSample sample =
          model->model().sample(event, {random.next(), random.next(), random.next(), random.next()});
      ASSERT_TRUE(std::isfinite(sample.value.objective) && sample.value.objective >= 0);
      objective += static_cast<double>(sample.value.objective);
      queries += sample.value.queries;
    }
    ASSERT_GT(queries, 0);
    if (rows == Rows::traced_at_vertex) {
      EXPECT_EQ(objective, 0);
    } else if (rows == Rows::absent) {
      EXPECT_EQ(objective, queries);
    } else if (rows == Rows::converged) {
      EXPECT_LT(objective / queries, 0.05);  // far nodes of the sampled theta_i are still open and count up to 1 each
    }
  }
}

// One direction pair: the mean over a 16 x 16 grid of xi against the Fourier reference at the exact (phi_r, theta_d).
// A grid of steps sigma/3 is good to 0.02 of L2 at 99 %: tolerance 0.05 in L2.
TEST(elliptical_model, mean_over_xi_is_the_reference_shape) {
  const FiberDirection known{0.35f, 0.63f};
  const float theta_i = 0.1f;
  FiberParameters parameters = clear_hair();
  parameters.sigma_a = glm::vec3(0.0f, 0.5f, 1.0f);
  const auto sigma = fiber::azimuthal_sigmas(parameters);
  const fiber::LobeWidths::At widths = fiber::LobeWidths::as_traced(parameters).at(known.theta);
  for (const Rows rows : {Rows::traced_at_vertex, Rows::absent, Rows::converged}) {
    const auto model = model_in(rows, parameters, known, false);
    for (const int p : {1, 2, 3}) {
      for (int channel = 0; channel < 3; ++channel) {
        const fiber::FourierReference reference({.eta = parameters.eta,
                                                 .eccentricity = parameters.eccentricity,
                                                 .theta_d = 0.5 * (known.theta - theta_i),
                                                 .phi_r = known.phi,
                                                 .sigma = sigma[static_cast<std::size_t>(p - 1)],
                                                 .sigma_a = parameters.sigma_a[channel],
                                                 .p = p});
        const int lane = fiber::LobeWidths::lane_of(p);
        const fiber::LongitudinalLobe m(known.theta, widths.tilt[lane] + widths.shift[lane], widths.lambda[lane]);
        double error = 0, variation = 0;
        const int points = 48, xis = rows == Rows::traced_at_vertex ? 1 : 16;
        for (int i = 0; i < points; ++i) {
          const float phi = -pi + 2 * pi * (static_cast<float>(i) + 0.5f) / points;
          double mean = 0;
          for (int j = 0; j < xis * xis; ++j) {
            const FiberEvent event = model->begin(known, (static_cast<float>(j % xis) + 0.5f) / static_cast<float>(xis),
                                                  (static_cast<float>(j / xis) + 0.5f) / static_cast<float>(xis));
            const auto lobe = static_cast<std::size_t>(p);
            mean += model->model().evaluate(event, {theta_i, phi}).s[lobe][channel] /
                    (event.energy[lobe][channel] * m.density(theta_i)) / (xis * xis);
          }
          const double expected = reference.density(phi) / reference.energy();
          error += (mean - expected) * (mean - expected);
          variation += (expected - 0.5 / pi) * (expected - 0.5 / pi);
        }
        EXPECT_LT(std::sqrt(error / variation), rows == Rows::converged ? 0.12 : 0.05)
            << name_of(rows) << " p " << p << " channel " << channel;
        std::printf("%s p %d channel %d: relative L2 %.4f\n", name_of(rows), p, channel, std::sqrt(error / variation));
      }
    }
  }
}

TEST(elliptical_model, equal_parameters_are_one_fiber_and_narrow_lobes_are_answered_exactly) {
  const auto target = fiber::make_elliptical_target();
  adaptive::Service service(adaptive::Options{}, *target);
  const auto model = *fiber::make_elliptical_model(fiber::Estimator::fitted, &service);
  FiberParameters narrow = clear_hair();
  narrow.azimuthal_sigma = {2 * degree, 10 * degree, 20 * degree};
  EXPECT_EQ(model->add_fiber(clear_hair()), model->add_fiber(clear_hair()));
  const fiber::FiberId id = model->add_fiber(narrow);
  EXPECT_NE(id, model->add_fiber(clear_hair()));
  EXPECT_EQ(service.slice_count(), 6u);

  const auto exact = *fiber::make_elliptical_model(fiber::Estimator::exact, nullptr);
  const fiber::FiberId exact_id = exact->add_fiber(narrow);
  const FiberDirection wr{0.2f, 0.5f};
  const FiberEvent event = model->begin(id, wr, 0.5f, 0.5f, 0), exact_event = exact->begin(exact_id, wr, 0.5f, 0.5f, 0);
  for (const float phi : {-3.0f, -2.0f, -1.0f, 2.6f}) {
    const FiberDirection wi{-0.1f, phi};
    EXPECT_EQ(model->evaluate(event, wi).s[1], exact->evaluate(exact_event, wi).s[1]);
  }
}

}  // namespace
}  // namespace tress
