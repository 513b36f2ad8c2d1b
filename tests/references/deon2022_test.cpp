// deon2022: the published lobes at right angles, what they return, and the law of its draws.
#include "references/models/deon2022.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fiber/direct_energies.h"
#include "models/model_measures.h"
#include "references/registry.h"
#include "support/quadrature.h"

namespace tress {
namespace {

using fiber::FiberEvent;
using fiber::FiberParameters;
using test::OneFiber;

constexpr float pi = std::numbers::pi_v<float>;

const fiber::ModelInfo& info() { return *references::find_model("deon2022"); }

FiberParameters clear_circle() {
  FiberParameters parameters;
  parameters.sigma_a = glm::vec3(0);
  parameters.eccentricity = 1;
  parameters.tilt = 0;
  return parameters;
}

double schlick(double cosine) {
  const double f0 = std::pow(0.55 / 2.55, 2);
  return f0 + (1 - f0) * std::pow(1 - cosine, 5);
}

// By ratios at one inclination: widths in theta_h of R at phi 0 and pi/2, TT and TRT.
TEST(deon2022, longitudinal_lobes_are_the_published_ones) {
  FiberParameters parameters = clear_circle();
  parameters.tilt = 0.06f;
  parameters.roughness = 0.1f;
  const OneFiber fiber(info(), parameters);
  const FiberEvent event = fiber.begin({0, 0});
  const auto s = [&](float theta_i, float phi, std::size_t p) {
    return double{fiber.model().evaluate(event, {theta_i, phi}).s[p].g};
  };
  const double slope = 0.1 / std::numbers::sqrt2;
  struct Case {
    std::size_t p;
    float phi;
    double tilt, width;
  };
  for (const Case& c : {Case{0, 0, -0.06, slope},
                        {0, pi / 2, -0.06, slope * std::cos(std::numbers::pi / 4)},
                        {1, 3, 0.03, 0.025 * std::sqrt(1.55 * 1.55 - 1)},
                        {2, 0.5f, 0.09, 0.1}}) {
    const auto mode = static_cast<float>(2 * c.tilt);
    constexpr float off = 1e-3f;  // of theta_i: a second difference of the logarithm at the mode
    const double bend =
        2 * std::log(s(mode, c.phi, c.p)) - std::log(s(mode - off, c.phi, c.p)) - std::log(s(mode + off, c.phi, c.p));
    const double width = 0.5 * double{off} / std::sqrt(bend);
    EXPECT_NEAR(width, c.width, 0.1 * c.width) << c.p << " " << c.phi;  // cosines and rounding bend, too
  }
}

// At right angles and for a narrow M, R and TT return their Fresnel terms over the offsets, to the width of M (0.07 of
// a radian: 1e-3); TRT what was fitted, near the traced energy.
TEST(deon2022, returns_its_fresnel_terms_at_right_angles) {
  FiberParameters parameters = clear_circle();
  parameters.roughness = 0.03f;
  const OneFiber fiber(info(), parameters);
  const FiberEvent event = fiber.begin({0, 0.3f});
  const auto cosine = [](double h) { return std::sqrt(1 - h * h); };
  EXPECT_NEAR(event.energy[0].g, test::integrate([&](double h) { return schlick(cosine(h)); }, 0, 1, 512), 2e-3);
  EXPECT_NEAR(event.energy[1].g,
              test::integrate([&](double h) { return std::pow(1 - schlick(cosine(h)), 2); }, 0, 1, 512), 0.01);
  const auto traced = test::direct_energies(1.55, 1, glm::vec3(0), 0.3, 0, 512, 300).clear;
  EXPECT_NEAR(event.energy[2].g, traced[2], 0.2f * traced[2]);
}

TEST(deon2022, energies_are_the_integrals_of_the_lobes) {
  FiberParameters parameters;
  parameters.sigma_a = glm::vec3(0.2f);
  const OneFiber fiber(info(), parameters);
  for (const float theta : {-1.2f, -0.6f, 0.2f, 1.1f}) {
    const FiberEvent event = fiber.begin({theta, 0.3f});
    float energy = 0;
    for (const glm::vec3& lobe : event.energy) energy += lobe.g;
    const double integral = test::masses(fiber.model(), event, 32, 24).s;
    EXPECT_NEAR(double{energy}, integral, 0.01 * integral) << theta;
  }
}

TEST(deon2022, absorbs_by_two_chords_and_by_a_constant_way) {
  const glm::vec3 sigma_a(0.1f, 0.5f, 1);
  for (int c = 0; c < 3; ++c) {
    const float tt = fiber::deon2022_azimuthal(1, 1.55f, 0.2f, sigma_a, 0, pi)[c],
                clear_tt = fiber::deon2022_azimuthal(1, 1.55f, 0.2f, glm::vec3(0), 0, pi)[c],
                trt = fiber::deon2022_azimuthal(2, 1.55f, 0.2f, sigma_a, 0, 0)[c],
                clear_trt = fiber::deon2022_azimuthal(2, 1.55f, 0.2f, glm::vec3(0), 0, 0)[c];
    EXPECT_NEAR(tt / clear_tt, std::exp(-2 * sigma_a[c]), 1e-5f);
    EXPECT_NEAR(trt / clear_trt, std::exp(-3.75f * sigma_a[c]), 1e-5f);
  }
}

// The density of draws has mass 1, and draws have its distribution at 16 quantiles (offsets of 4096 midpoints).
TEST(deon2022, draws_follow_their_density) {
  for (const float theta_d : {0.0f, 0.6f, 1.2f})
    for (const int p : {1, 2}) {
      const fiber::Deon2022Draws draws(1.55f, 0.2f, theta_d);
      const auto below = [&](double x) {
        return test::integrate([&](double at) { return double{draws.density(p, static_cast<float>(at))}; }, -pi, x,
                               4096);
      };
      EXPECT_NEAR(below(pi), 1, 2e-3);
      constexpr int side = 128;
      for (const double x : {-2.0, -0.7, 0.1, 1.3, 2.8}) {
        int under = 0;
        for (int i = 0; i < side; ++i)
          for (int k = 0; k < side; ++k)
            under += double{draws.sample(p, (static_cast<float>(i) + 0.5f) / side,
                                         (static_cast<float>(k) + 0.5f) / side)} < x;
        EXPECT_NEAR(under / double{side * side}, below(x), 0.01) << p << " " << theta_d << " " << x;
      }
    }
}

}  // namespace
}  // namespace tress
