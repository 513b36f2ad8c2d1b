#include "fiber/reflection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fiber/cross_section.h"
#include "fiber/direct_energies.h"
#include "fiber/fresnel.h"
#include "support/quadrature.h"

namespace {

using namespace tress;
constexpr double pi = std::numbers::pi;

struct Case {
  float eccentricity, theta_r, phi_r, energy;
};

std::vector<Case> make_cases() {
  std::vector<Case> all;
  for (float e : {0.5f, 0.85f, 1.0f}) {
    for (float theta : {0.0f, 0.8f, 1.5f, fiber::half_pi}) {
      for (float phi : {0.0f, 0.6f, float(pi / 2), -2.2f, 3.1f}) {
        all.push_back({e, theta, phi, test::direct_energies(1.55, e, glm::vec3(0), phi, theta, 2048, 0).clear[0]});
      }
    }
  }
  return all;
}

const std::vector<Case>& cases() {
  static const std::vector<Case> all = make_cases();
  return all;
}

TEST(Reflection, PdfIntegratesToOneAndEnergyToTheTracedOne) {
  for (const Case& c : cases()) {
    const fiber::ReflectionLobe lobe(1.55f, c.eccentricity, c.theta_r, c.phi_r, c.energy, -0.05f, 0.1f);
    const double from = c.phi_r - pi, to = c.phi_r + pi;  // the pdf jumps at the antipode: the ends of the range
    EXPECT_NEAR(test::integrate([&](double phi) { return lobe.azimuth_pdf(float(phi)); }, from, to, 512), 1, 2e-5);
    // 2048 midpoints of the traced energy: the square-root edge of F at grazing costs about n^-1.5 = 1e-5.
    EXPECT_NEAR(test::integrate([&](double phi) { return lobe.energy_density(float(phi)); }, from, to, 512), c.energy,
                5e-5)
        << c.eccentricity << ' ' << c.theta_r << ' ' << c.phi_r;
  }
}

TEST(Reflection, ClosedFormIsTheTracedLobe) {
  // Mass of the closed form over 60 sectors against the exits of 65536 rays: a sector boundary misplaces at most one
  // ray, 1.5e-5 of mass at each end; 4e-5 leaves room for float azimuths.
  constexpr int sectors = 60, rays = 65536;
  for (const Case& c : cases()) {
    const fiber::ReflectionLobe lobe(1.55f, c.eccentricity, c.theta_r, c.phi_r, c.energy, 0, 0.1f);
    const fiber::CrossSection section(1.55, c.eccentricity, c.phi_r, c.theta_r);
    std::vector<double> traced(sectors);
    for (int i = 0; i < rays; ++i) {
      fiber::TracedOffset offset;
      section.trace((2 * i + 1.0) / rays - 1, 0, &offset);
      double x = std::remainder(offset.azimuth[0] - double(c.phi_r), 2 * pi) + pi;
      traced[std::size_t(std::min(x / (2 * pi) * sectors, sectors - 1.0))] += offset.weight[0] / rays;
    }
    for (int s = 0; s < sectors; ++s) {
      const double from = c.phi_r - pi + 2 * pi * s / sectors;
      const double mass = test::integrate([&](double phi) { return lobe.energy_density(float(phi)); }, from,
                                          from + 2 * pi / sectors, 32);
      EXPECT_NEAR(mass, traced[std::size_t(s)], 4e-5) << c.eccentricity << ' ' << c.theta_r << ' ' << c.phi_r;
    }
  }
}

TEST(Reflection, EveryKindOfFresnelHasItsEnergy) {
  using Kind = fiber::ReflectionFresnel;
  for (const Case& c : cases()) {
    for (const Kind kind : {Kind::exact, Kind::longitudinal, Kind::bravais, Kind::none}) {
      const fiber::ReflectionLobe lobe(1.55f, c.eccentricity, c.theta_r, c.phi_r, c.energy, 0, 0.1f, kind);
      const double from = c.phi_r - pi, to = c.phi_r + pi;
      // The roots at the kinks of `bravais` cost a panel's width to the 1.5, times its peak: 1e-5 of 4096 panels.
      const double mass = test::integrate([&](double phi) { return lobe.energy_density(float(phi)); }, from, to, 4096);
      const float energy = fiber::reflected_energy(kind, 1.55f, c.eccentricity, c.theta_r, c.phi_r);
      EXPECT_NEAR(mass, energy, 5e-5) << int(kind) << ' ' << c.eccentricity << ' ' << c.theta_r << ' ' << c.phi_r;
      // The sampler does not know of Fresnel.
      const fiber::ReflectionLobe exact(1.55f, c.eccentricity, c.theta_r, c.phi_r, c.energy, 0, 0.1f);
      EXPECT_EQ(lobe.azimuth_pdf(c.phi_r + 1), exact.azimuth_pdf(c.phi_r + 1));
      EXPECT_EQ(lobe.sample_azimuth(0.3f), exact.sample_azimuth(0.3f));
      if (kind == Kind::none) {
        EXPECT_EQ(energy, 1);
      }
      if (kind == Kind::exact) {  // the traced one, of 2048 midpoints
        EXPECT_NEAR(energy, c.energy, 5e-5);
      }
    }
  }
}

TEST(Reflection, KindsOfFresnelAreWhatTheySay) {
  using Kind = fiber::ReflectionFresnel;
  for (const float theta : {0.0f, 0.7f, 1.4f}) {
    const double eta_prime = fiber::bravais_index(1.55, theta), other = 1.55 * 1.55 / eta_prime;
    const auto kind = [&](Kind k) { return fiber::SurfaceFresnel(1.55f, theta, k); };
    double cos_t;
    for (const float cosine : {0.02f, 0.3f, 0.8f, 1.0f}) {
      // Single precision: 2e-6, more at grazing where terms cancel.
      EXPECT_NEAR(kind(Kind::exact)(cosine), fiber::fresnel_entering(1.55, eta_prime, cosine, &cos_t), 1e-5);
      EXPECT_NEAR(kind(Kind::longitudinal)(cosine), fiber::fresnel_entering(1.55, eta_prime, 1, &cos_t), 1e-5);
      EXPECT_EQ(kind(Kind::none)(cosine), 1);
      // Two-dimensional Fresnel of index n: s with eta', p with eta''.
      const double s_t = std::sqrt(1 - (1 - cosine * cosine) / (eta_prime * eta_prime));
      const double s = (cosine - eta_prime * s_t) / (cosine + eta_prime * s_t);
      const double p_sin2 = (1 - cosine * cosine) / (other * other), p_t = std::sqrt(std::max(1 - p_sin2, 0.0));
      const double p = p_sin2 >= 1 ? 1 : (other * cosine - p_t) / (other * cosine + p_t);
      EXPECT_NEAR(kind(Kind::bravais)(cosine), 0.5 * (s * s + p * p), 1e-5) << theta << ' ' << cosine;
    }
  }
  // At normal incidence in the normal plane all but `none` agree where nothing is inclined.
  EXPECT_NEAR(fiber::SurfaceFresnel(1.55f, 0, Kind::bravais)(1), 0.0465, 1e-4);
}

TEST(Reflection, WidthFollowsTheHalfAngle) {
  const fiber::ReflectionLobe lobe(1.55f, 0.85f, 0.3f, 0.0f, 0.1f, 0, 0.04f);
  // The peak of M is 1/(8 lambda) where nothing is cut off.
  EXPECT_NEAR(lobe.longitudinal(0.0f).density(-0.3f), 1 / 0.32, 1e-4);
  EXPECT_NEAR(lobe.longitudinal(2.0f).density(-0.3f), 1 / (0.32 * std::cos(1.0)), 1e-3);
}

TEST(Reflection, EveryInputGivesFiniteValues) {
  for (float eta : {1.05f, 1.55f, 3.0f}) {
    for (const Case& c : cases()) {
      const fiber::ReflectionLobe lobe(eta, c.eccentricity, c.theta_r, c.phi_r, c.energy, 0, 0.1f);
      for (float u : {0.0f, 0.25f, 0.5f, 0.75f, 0.99999994f}) {
        const float phi = lobe.sample_azimuth(u);
        ASSERT_GE(phi, -float(pi) - 1e-6f);
        ASSERT_LT(phi, float(pi));
        ASSERT_TRUE(std::isfinite(lobe.energy_density(phi)) && lobe.energy_density(phi) >= 0);
        ASSERT_TRUE(std::isfinite(lobe.azimuth_pdf(phi)) && lobe.azimuth_pdf(phi) > 0);
        ASSERT_TRUE(std::isfinite(lobe.longitudinal(phi).density(lobe.longitudinal(phi).sample(u))));
      }
    }
  }
}

}  // namespace
