// ou2012: the published lobes at right angles, what they return, and bounded weights.
#include "references/models/ou2012.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fiber/direct_energies.h"
#include "models/model_measures.h"
#include "references/models/ou2012_lobes.h"
#include "references/registry.h"
#include "support/quadrature.h"

namespace tress {
namespace {

using fiber::FiberDirection;
using fiber::FiberEvent;
using fiber::FiberParameters;
using test::OneFiber;

constexpr float pi = std::numbers::pi_v<float>;

const fiber::ModelInfo& info() { return *references::find_model("ou2012"); }

FiberParameters clear_circle() {
  FiberParameters parameters;
  parameters.sigma_a = glm::vec3(0);
  parameters.eccentricity = 1;
  parameters.tilt = 0;
  return parameters;
}

// The published shapes, by ratios at one inclination: cos(phi/2), and Gaussians about pi and the caustic.
TEST(ou2012, azimuthal_lobes_are_the_published_ones) {
  FiberParameters parameters = clear_circle();
  parameters.split_glint = true;
  parameters.reflection_fresnel = fiber::ReflectionFresnel::none;
  const OneFiber fiber(info(), parameters);
  const FiberEvent event = fiber.begin({0.4f, 0.9f});
  const fiber::CircleFarField far(1.55f, glm::vec3(0), fiber::azimuthal_sigmas(parameters)[1]);
  const float sigma_tt = fiber::azimuthal_sigmas(parameters)[0], sigma_g = fiber::azimuthal_sigmas(parameters)[1];
  const float gamma_tt = std::hypot(far.deviation_tt, sigma_tt);
  const auto at = [&](float phi) { return fiber.model().evaluate(event, {-0.3f, 0.9f + phi}).s; };
  const auto zero = at(0), back = at(pi);
  for (const float phi : {-2.5f, -0.8f, 0.3f, 1.9f, 3.0f}) {
    const auto s = at(phi);
    const auto gaussian = [](float x, float width) { return std::exp(-0.5f * x * x / (width * width)); };
    EXPECT_NEAR(s[0].g / zero[0].g, std::cos(phi / 2), 1e-5);
    EXPECT_NEAR(s[2].g / zero[2].g, std::cos(phi / 2), 1e-5);
    EXPECT_NEAR(s[1].g / back[1].g, gaussian(pi - std::abs(phi), gamma_tt), 1e-5);
    EXPECT_NEAR(s[5].g / zero[5].g * gaussian(far.caustic, sigma_g), gaussian(std::abs(phi) - far.caustic, sigma_g),
                1e-5);
  }
}

TEST(ou2012, longitudinal_lobes_are_the_published_ones) {
  FiberParameters parameters = clear_circle();
  parameters.tilt = 0.06f;
  const OneFiber fiber(info(), parameters);
  const float theta_r = 0.5f;
  const FiberEvent event = fiber.begin({theta_r, 0});
  const auto at = [&](float theta_i) { return fiber.model().evaluate(event, {theta_i, 2.0f}).s; };
  const float from = -0.45f;
  for (const float to : {-1.2f, -0.7f, 0.1f}) {
    for (const std::size_t p : {std::size_t{0}, std::size_t{1}}) {
      const float beta = 1.8137994f * fiber::longitudinal_lambda(parameters, static_cast<int>(p), 0);
      const auto expected = [&](float theta_i) {
        const float x = 0.5f * (theta_i + theta_r) - fiber::lobe_tilt(parameters, static_cast<int>(p));
        const float cosines = std::cos(theta_i) / std::cos(0.5f * (theta_r - theta_i));
        return std::exp(-0.5f * x * x / (beta * beta)) * cosines * cosines;
      };
      EXPECT_NEAR(at(to)[p].g / at(from)[p].g, expected(to) / expected(from),
                  2e-5f * expected(to) / expected(from) + 1e-6f);
    }
  }
}

// At right angles and without a tilt each lobe returns the traced energy of its order (512 rays there, 512 here; 64
// midpoints of M: 1e-4), and what comes after TRT is missing.
TEST(ou2012, returns_the_traced_energies_at_right_angles_and_not_elsewhere) {
  const OneFiber fiber(info(), clear_circle());
  const FiberEvent event = fiber.begin({0, 0.3f});
  const auto expected = test::direct_energies(1.55, 1, glm::vec3(0), 0.3, 0, 512, 300).clear;
  for (std::size_t p = 0; p < 3; ++p) EXPECT_NEAR(event.energy[p].g, expected[p], 2e-4f) << fiber::lobe_names[p];
  const double all = test::masses(fiber.model(), event, 24, 16).s;
  EXPECT_NEAR(all, double{expected[0] + expected[1] + expected[2]}, 1e-3);
  EXPECT_NEAR(1 - all, double{expected[3] + expected[4]}, 1e-3);
  EXPECT_GT(test::masses(fiber.model(), fiber.begin({1.4f, 0.3f}), 24, 16).s, 1.2);
}

// The energies that choose lobes are those of the lobes: table of 128 steps, 1e-2 of what little is left at grazing.
TEST(ou2012, energies_are_the_integrals_of_the_lobes) {
  FiberParameters parameters;
  parameters.sigma_a = glm::vec3(0.2f);
  const OneFiber fiber(info(), parameters);
  for (const float theta : {-1.3f, -0.6f, 0.2f, 1.1f, 1.45f}) {
    const FiberEvent event = fiber.begin({theta, 0.3f});
    float energy = 0;
    for (const glm::vec3& lobe : event.energy) energy += lobe.g;
    const double integral = test::masses(fiber.model(), event, 32, 16).s;
    EXPECT_NEAR(double{energy}, integral, 0.01 * integral) << theta;
  }
}

// A Gaussian over the Cauchy law of its scale is at most 1.52, in theta and in phi each (2.3); Fresnel, and what the
// inclination changes (up to 4 at the poles), come on top: 3 up to 60 degrees.
TEST(ou2012, weights_are_bounded) {
  for (const float theta : {0.0f, 0.5f, 1.05f}) {
    const OneFiber fiber(info(), clear_circle());
    const test::Weights weights = test::weights(fiber, {theta, 0.3f}, 20000, 3);
    EXPECT_LT(weights.largest, 3) << theta;
    std::printf("theta_r %.2f: mean weight %.3f, largest %.2f\n", static_cast<double>(theta), weights.mean,
                weights.largest);
  }
}

TEST(ou2012, bumps_have_their_mass_and_density_one) {
  for (const float centre : {0.0f, 0.33f, 2.1f, pi}) {
    for (const float width : {0.009f, 0.3f, 1.5f}) {
      const fiber::AzimuthalBump bump(centre, width);
      double mass = 0, pdf = 0;
      for (const auto& [from, to] : {std::pair{-pi, -centre}, {-centre, 0.0f}, {0.0f, centre}, {centre, pi}}) {
        mass += test::integrate([&](double x) { return bump.height(static_cast<float>(x)); }, from, to, 256);
        pdf += test::integrate([&](double x) { return bump.pdf(static_cast<float>(x)); }, from, to, 256);
      }
      EXPECT_NEAR(mass, double{bump.mass()}, 1e-5);
      EXPECT_NEAR(pdf, 1, 1e-5);
    }
  }
}

}  // namespace
}  // namespace tress
