// The paper's own model: its closed forms, its grid, the rows that are fitted to Marschner's functions, its energy as
// documented, as printed beside as corrected, its values at every corner of the parameters.
#include "references/models/pekelis2015.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <vector>

#include "fiber/cross_section.h"
#include "references/models/pekelis2015_target.h"
#include "references/registry.h"
#include "references/taught_pekelis.h"
#include "support/chi_square.h"
#include "tress/adaptive/traced_nodes.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::fiber {
namespace {

constexpr double pi = std::numbers::pi, degree = pi / 180;
constexpr auto corrected = PekelisReading::corrected, printed = PekelisReading::as_printed;

TEST(pekelis2015_terms, reflection_has_mass_one_and_is_sampled) {
  for (const float sigma : {0.5f, 1.0f, 3.0f, 10.0f}) {
    double mass = 0;
    constexpr int n = 4000;
    for (int i = 0; i < n; ++i) {
      const auto phi = static_cast<float>(-pi + 2 * pi * (i + 0.5) / n);
      mass += static_cast<double>(pekelis_reflection(phi, sigma)) * 2 * pi / n;
    }
    EXPECT_NEAR(mass, 1, 1e-4);
    for (const float u : {0.01f, 0.2f, 0.5f, 0.77f, 0.999f}) {
      double below = 0;
      const auto phi = static_cast<double>(sample_pekelis_reflection(u, sigma));
      for (int i = 0; i < n; ++i) {
        const double x = -pi + (phi + pi) * (i + 0.5) / n;
        below += static_cast<double>(pekelis_reflection(static_cast<float>(x), sigma)) * (phi + pi) / n;
      }
      EXPECT_NEAR(below, static_cast<double>(u), 1e-3) << sigma;
    }
  }
}

// Both scales against TT itself, Marschner's in the normal plane, by the error of the paper's section 7.1: the
// corrected one is near, the printed one is not, and none below eta' = 1.188.
TEST(pekelis2015_terms, corrected_scale_of_tt_is_near_and_the_printed_one_is_not) {
  for (const double eta_prime : {1.3, 1.55, 2.0, 3.0}) {
    const MarschnerCircle circle(eta_prime, eta_prime, 0);
    std::array<double, 2> error{};
    for (const PekelisReading reading : {corrected, printed}) {
      const adaptive::SkewLogistic lobe =
          pekelis_transmission(pekelis_transmission_scale(static_cast<float>(eta_prime), reading));
      double difference = 0, variation = 0;
      constexpr int n = 3600;
      for (int i = 0; i < n; ++i) {
        const double phi = -pi + 2 * pi * (i + 0.5) / n;
        double density = 0;
        const MarschnerPaths paths = circle.paths(1, phi);
        for (std::size_t k = 0; k < paths.count; ++k) density += paths.path[k].density;
        const double d = density - static_cast<double>(lobe.density(static_cast<float>(phi)));
        difference += d * d;
        variation += (density - 0.5 / pi) * (density - 0.5 / pi);
      }
      error[static_cast<std::size_t>(reading)] = difference / variation;
    }
    std::printf("eta' %.2f: error of N_TT corrected %.3f, as printed %.3f\n", eta_prime, error[0], error[1]);
    EXPECT_LT(error[0], 0.12);
    EXPECT_GT(error[1], 2.5 * error[0]);
  }
  EXPECT_EQ(pekelis_transmission_scale(1.18f, printed), pekelis_transmission_scale(1.18f, corrected));
}

// In the normal plane the attenuation is that of the traced circle, light of every order that enters at h; straight
// through, the color is C.
TEST(pekelis2015_terms, attenuation_is_that_of_the_traced_circle) {
  const CrossSection section(1.55, 1, 0, 0);
  const glm::vec3 color(0.8f, 0.4f, 0.1f), zeta = pekelis_zeta(color, corrected);
  const PekelisAttenuation attenuation(1.55f, 0, zeta, corrected);
  for (const double h : {0.0, 0.3, 0.7, 0.95}) {
    TracedOffset offset;
    section.trace(h, 2, &offset);
    for (const int order : {1, 2}) {
      const auto p = static_cast<std::size_t>(order);
      const glm::vec3 here = attenuation(order, static_cast<float>(std::sqrt(1 - h * h)));
      for (int c = 0; c < 3; ++c) {
        const double traced = offset.weight[p] * std::exp(-static_cast<double>(zeta[c]) * offset.path[p]);
        EXPECT_NEAR(static_cast<double>(here[c]), traced, 1e-5);
      }
    }
  }
  for (const PekelisReading reading : {corrected, printed}) {
    const PekelisAttenuation clear(1.55f, 0, glm::vec3(0), reading);
    const PekelisAttenuation absorbed(1.55f, 0, pekelis_zeta(color, reading), reading);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(absorbed(1, 1)[c] / clear(1, 1)[c], color[c], 1e-6);
  }
  // At 60 degrees they are apart: the printed path grows as 1/cos theta_D, the true one as 1/cos theta_t.
  const PekelisAttenuation steep(1.55f, 1.047f, zeta, corrected);
  const PekelisAttenuation as_printed(1.55f, 1.047f, pekelis_zeta(color, printed), printed);
  EXPECT_GT(steep(1, 1).g, 1.5f * as_printed(1, 1).g);
}

TEST(pekelis2015_grid, has_the_rows_of_the_paper) {
  for (const MarschnerLobe lobe : {MarschnerLobe::trt, MarschnerLobe::glint}) {
    std::uint32_t rows = 0;
    for (const float e : {0.85f, 0.9f, 0.95f, 1.0f}) {
      for (const double sigma : {10.0, 15.0, 20.0, 25.0}) {
        rows += pekelis_slice(lobe, 1.55f, e, static_cast<float>(sigma * degree)).node_count();
      }
    }
    EXPECT_EQ(rows, 25572u);
  }
  EXPECT_EQ(nearest_pekelis_eccentricity(0.5f), 0.85f);
  EXPECT_EQ(nearest_pekelis_eccentricity(0.93f), 0.95f);
  EXPECT_NEAR(static_cast<double>(nearest_pekelis_sigma(static_cast<float>(17.6 * degree))), 20 * degree, 1e-6);
  EXPECT_NEAR(static_cast<double>(nearest_pekelis_sigma(1.5f)), 25 * degree, 1e-6);
  const adaptive::SliceDescription slice = pekelis_slice(MarschnerLobe::trt, 1.55f, 0.85f, 0.3f);
  const PekelisNode node =
      nearest_pekelis_node(slice, static_cast<float>(30.9 * degree), static_cast<float>(-45.1 * degree));
  EXPECT_EQ(node.a, 15u);
  EXPECT_EQ(node.b, 23u);
  const PekelisNode last = nearest_pekelis_node(pekelis_slice(MarschnerLobe::trt, 1.55f, 1, 0.3f), 1.5f, 1.57f);
  EXPECT_EQ(last.a, 0u);
  EXPECT_EQ(last.b, 44u);
}

// The target is the curve but for its blur, and has its mass: 300 rows, seed 5.
TEST(pekelis2015_target, is_the_function_of_marschner) {
  const PekelisTarget target;
  RandomStream random(5);
  std::vector<double> errors;
  for (int i = 0; i < 300; ++i) {
    const auto index = [&](std::size_t size) {
      return static_cast<std::size_t>(random.next() * static_cast<float>(size));
    };
    const MarschnerLobe lobe = i % 2 == 0 ? MarschnerLobe::trt : MarschnerLobe::glint;
    constexpr std::array<float, 4> all_e{0.85f, 0.9f, 0.95f, 1.0f};
    const float sigma = static_cast<float>((10 + 5 * static_cast<double>(index(4))) * degree);
    const adaptive::SliceDescription slice = pekelis_slice(lobe, 1.55f, all_e[index(4)], sigma);
    const float a = slice.axis_a[index(slice.axis_a.size())], b = slice.axis_b[index(slice.axis_b.size())];
    std::vector<adaptive::TracedRay> rays;
    target.trace(slice, a, b, rays);
    const adaptive::TracedNodes nodes(rays, slice.blur_rad);
    constexpr int n = 1800;
    std::vector<double> curve;
    double mass = 0, difference = 0, variation = 0;
    for (int k = 0; k < n; ++k) {
      curve.push_back(
          pekelis_curve(slice.key, static_cast<double>(a), static_cast<double>(b), -pi + 2 * pi * (k + 0.5) / n));
      mass += curve.back() * 2 * pi / n;
    }
    EXPECT_NEAR(static_cast<double>(nodes.energy()), mass, 2e-3);
    if (mass < 1e-3) continue;
    for (int k = 0; k < n; ++k) {
      const double d = curve[static_cast<std::size_t>(k)] -
                       static_cast<double>(nodes.density(static_cast<float>(-pi + 2 * pi * (k + 0.5) / n)));
      difference += d * d;
      variation += (curve[static_cast<std::size_t>(k)] - mass / (2 * pi)) *
                   (curve[static_cast<std::size_t>(k)] - mass / (2 * pi));
    }
    errors.push_back(difference / variation);
  }
  std::sort(errors.begin(), errors.end());
  std::printf("blur: error median %.2g, largest of %zu %.2g\n", errors[errors.size() / 2], errors.size(),
              errors.back());
  EXPECT_LT(errors[errors.size() / 2], 5e-5);
  EXPECT_LT(errors.back(), 5e-3);
}

// Integral of S by midpoints, 1 degree in theta_i, 5 in phi, mean over the folded azimuth.
double furnace_of(const FiberModel& model, FiberId fiber, float theta, bool round) {
  double integral = 0;
  const int events = round ? 1 : 4;
  constexpr int inclinations = 180, azimuths = 72;
  for (int i = 0; i < events; ++i) {
    const FiberDirection wr{theta * static_cast<float>(degree), static_cast<float>(0.5 * pi * (i + 0.5) / events)};
    const FiberEvent event = model.begin(fiber, wr, 0.5f, 0.5f, 0);
    for (int t = 0; t < inclinations; ++t) {
      for (int a = 0; a < azimuths; ++a) {
        const FiberDirection wi{static_cast<float>(pi * ((t + 0.5) / inclinations - 0.5)),
                                static_cast<float>(2 * pi * ((a + 0.5) / azimuths - 0.5))};
        integral +=
            static_cast<double>(model.evaluate(event, wi).total().g) * pi / inclinations * 2 * pi / azimuths / events;
      }
    }
  }
  return integral;
}

// The white furnace is REPORTED, it is not 1: what the header says, alpha = 0.2, and what the printed reading gives,
// whose factor of eq. 2 makes 41 of it at 85 degrees.
TEST(pekelis2015, furnace_is_what_the_documents_say) {
  struct Row {
    PekelisReading reading;
    float e, theta;
    double furnace, tolerance;
  };
  constexpr Row rows[] = {{corrected, 1, 0, 0.974, 0.005},      {corrected, 1, 60, 0.957, 0.005},
                          {corrected, 1, 75, 1.013, 0.005},     {corrected, 1, 85, 1.270, 0.005},
                          {corrected, 0.85f, 0, 0.985, 0.005},  {corrected, 0.85f, 60, 0.963, 0.005},
                          {corrected, 0.85f, 85, 1.270, 0.005}, {printed, 1, 0, 1.264, 0.01},
                          {printed, 1, 60, 1.824, 0.01},        {printed, 1, 85, 40.96, 0.3}};
  for (const Row& row : rows) {
    FiberParameters parameters;
    parameters.sigma_a = glm::vec3(0);
    parameters.eccentricity = row.e;
    const auto model = make_pekelis2015({.estimator = Estimator::exact}, row.reading);
    const double furnace = furnace_of(*model, model->add_fiber(parameters), row.theta, row.e >= 1);
    std::printf("%s, e %.2f theta %2.0f: furnace %.3f\n", row.reading == corrected ? "corrected" : "as printed",
                static_cast<double>(row.e), static_cast<double>(row.theta), furnace);
    EXPECT_NEAR(furnace, row.furnace, row.tolerance);
  }
}

// Once taught at one known direction, rows answer, whichever learner made them: no query of those that always converge
// is exact (the others leave rows to their target, which then answers), and what they say is Marschner's function at
// the node to epsilon.
TEST(pekelis2015, converged_rows_answer_as_their_targets) {
  for (const adaptive::Learner* learner : references::learners()) {
    FiberParameters parameters;
    parameters.sigma_a = glm::vec3(0);
    test::TaughtPekelis taught(parameters, corrected, learner);
    // A node of the grid, so that the model without rows reads the same curve.
    const FiberDirection wr{static_cast<float>(20 * degree), static_cast<float>(40 * degree)};
    taught.teach(wr, 24, 400);
    for (std::size_t d = 6; d < taught.report().components.size(); ++d) EXPECT_EQ(taught.report().components[d], 0u);
    const auto exact = make_pekelis2015({.estimator = Estimator::exact}, corrected);
    const FiberId id = exact->add_fiber(parameters);
    const FiberEvent event = taught.begin(wr), reference = exact->begin(id, wr, 0, 0, 0);
    // theta_i = -theta_r: theta_d is that of the node.
    constexpr int n = 360;
    int exact_queries = 0;
    double difference = 0, variation = 0, mean = 0;
    std::vector<double> values;
    for (int i = 0; i < n; ++i) {
      const FiberDirection wi{-wr.theta, static_cast<float>(-pi + 2 * pi * (i + 0.5) / n)};
      const FiberValue value = taught.model().evaluate(event, wi);
      EXPECT_EQ(value.queries, 2);
      exact_queries += value.exact_queries;
      const auto trt = static_cast<std::size_t>(Lobe::trt);
      const double a = static_cast<double>(value.s[trt].g);
      values.push_back(static_cast<double>(exact->evaluate(reference, wi).s[trt].g));
      mean += values.back() / n;
      difference += (a - values.back()) * (a - values.back());
    }
    for (const double value : values) variation += (value - mean) * (value - mean);
    std::printf("%s: TRT and GLINT together against the curves: %.2g\n", learner->name, difference / variation);
    if (learner == &adaptive::sketch_learner || learner == &references::eager_learner) {
      EXPECT_EQ(exact_queries, 0) << learner->name;
    }
    // Two rows below epsilon 0.01 each, at their bounds, and the blur.
    EXPECT_LT(difference / variation, 0.02) << learner->name;
  }
}

TEST(pekelis2015, is_finite_with_bounded_weights_at_every_corner) {
  RandomStream random(5);
  float largest = 0;
  for (const PekelisReading reading : {corrected, printed}) {
    for (const float eta : {1.05f, 1.55f, 3.0f}) {
      for (const float e : {0.5f, 1.0f}) {
        for (const float roughness : {0.01f, 0.2f, 1.0f}) {
          FiberParameters parameters;
          parameters.eta = eta;
          parameters.eccentricity = e;
          parameters.roughness = roughness;
          parameters.sigma_a = glm::vec3(0, 0.5f, 1e4f);
          parameters.split_glint = roughness > 0.1f;
          test::TaughtPekelis taught(parameters, reading);
          const auto exact = make_pekelis2015({.estimator = Estimator::exact}, reading);
          ASSERT_EQ(exact->add_fiber(parameters), exact->add_fiber(parameters));
          for (const FiberModel* model : {static_cast<const FiberModel*>(exact.get()), &taught.model()}) {
            for (const float theta : {0.0f, 1.5707964f, -1.5707964f}) {
              for (const float phi : {0.0f, -3.1415927f, 2.5f}) {
                const FiberEvent event = model->begin(0, {theta, phi}, 0, 0.99f, 1);
                const auto check = [&](const FiberValue& value) {
                  ASSERT_TRUE(std::isfinite(value.pdf) && value.pdf > 0);
                  for (const glm::vec3& s : value.s) {
                    for (int c = 0; c < 3; ++c) ASSERT_TRUE(std::isfinite(s[c]) && s[c] >= 0);
                  }
                };
                for (int i = 0; i < 6; ++i) {
                  const FiberSample sample =
                      model->sample(event, {random.next(), random.next(), random.next(), random.next()});
                  check(sample.value);
                  if (reading == corrected) largest = std::max(largest, sample.value.total().r / sample.value.pdf);
                }
                for (const float end : {0.0f, 0.99999994f}) check(model->sample(event, {end, end, end, end}).value);
                for (const float theta_i : {-1.5707964f, 0.0f, 1.5707964f}) {
                  for (const float phi_i : {-3.1415927f, 0.0f, 3.1415925f}) {
                    check(model->evaluate(event, {theta_i, phi_i}));
                  }
                }
              }
            }
          }
        }
      }
    }
  }
  std::printf("largest weight %.1f\n", static_cast<double>(largest));
  // A lobe has a fiftieth of the choice at least and a weight of at most some units: the gain of its attenuation, or,
  // for `exact`, what its tables are off.
  EXPECT_LT(largest, 400);
}

}  // namespace
}  // namespace tress::inline v0_2::fiber
