// Surfaces of meshes: energy, reciprocity, and the coat's albedo against another quadrature.
#include "integrate/surface_scattering.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace tress::integrate {
namespace {

constexpr double pi = std::numbers::pi;

glm::vec3 at_cosine(double cosine, double azimuth = 0.3) {
  const double sine = std::sqrt(1 - cosine * cosine);
  return {static_cast<float>(sine * std::cos(azimuth)), static_cast<float>(sine * std::sin(azimuth)),
          static_cast<float>(cosine)};
}

/// Of f(in), which has its cosine, over the hemisphere by midpoints in cosine and azimuth: fine beside lobes of a width
/// of 0.15 and more.
template <class Function>
double over_hemisphere(const Function& f) {
  constexpr int rings = 240, around = 240;
  double sum = 0;
  for (int i = 0; i < rings; ++i)
    for (int k = 0; k < around; ++k) sum += double{f(at_cosine((i + 0.5) / rings, 2 * pi * (k + 0.5) / around))};
  return 2 * pi * sum / (rings * around);
}

// A white surface under any coat sends back all of a constant light, within 1 %, and a grey one less.
TEST(SurfaceMaterial, WhiteUnderACoatSendsBackAllOfTheLight) {
  for (const float roughness : {0.4f, 0.7f, 1.0f})
    for (const float eta : {1.3f, 2.0f}) {
      const Coat coat(roughness, eta);
      for (const double cosine : {0.1, 0.5, 1.0}) {
        const SurfaceMaterial white(glm::vec3(1.0f), &coat, at_cosine(cosine)), grey(glm::vec3(0.5f), &coat, white.out);
        const double sent = over_hemisphere([&](const glm::vec3& in) { return white.value(in).x; });
        EXPECT_NEAR(sent, 1, 0.01) << roughness << " " << eta << " " << cosine;
        EXPECT_EQ(white.albedo(), glm::vec3(1.0f));
        const double of_grey = over_hemisphere([&](const glm::vec3& in) { return grey.value(in).x; });
        EXPECT_NEAR(of_grey, double{grey.albedo().x}, 0.01);
        EXPECT_LT(of_grey, 0.95);
      }
    }
}

TEST(Coat, ItsAlbedoIsTheIntegralOfItsValue) {
  for (const float roughness : {0.4f, 0.8f}) {
    const Coat coat(roughness, 1.5f);
    double mean = 0;
    for (int i = 0; i < 20; ++i) {
      const double cosine = (i + 0.5) / 20;
      const glm::vec3 out = at_cosine(cosine);
      const double integral = over_hemisphere([&](const glm::vec3& in) { return coat.value(out, in); });
      // Nearer to grazing the lobe is narrower in azimuth than the midpoints are apart; it weighs 2 % of the mean.
      if (cosine > 0.15) {
        EXPECT_NEAR(double{coat.albedo(static_cast<float>(cosine))}, integral, 0.002) << cosine;
      }
      mean += 2 * integral * cosine / 20;
    }
    EXPECT_NEAR(double{coat.mean_albedo()}, mean, 0.002) << roughness;
  }
}

// By hand: nearly smooth and seen from above it mirrors ((eta - 1) / (eta + 1))^2.
TEST(Coat, SeenFromAboveASmoothOneMirrorsAsFresnelSays) {
  EXPECT_NEAR(Coat(0.05f, 1.5f).albedo(1), 0.04, 2e-4);
  EXPECT_NEAR(Coat(0.05f, 2.0f).albedo(1), 1.0 / 9, 4e-4);
}

TEST(SurfaceMaterial, IsReciprocal) {
  const Coat coat(0.4f, 1.5f);
  const glm::vec3 a = at_cosine(0.8, 0.1), b = at_cosine(0.25, 2.0);
  const SurfaceMaterial from_a({0.2f, 0.5f, 0.9f}, &coat, a), from_b({0.2f, 0.5f, 0.9f}, &coat, b);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(from_a.value(b)[c] / b.z, from_b.value(a)[c] / a.z, 1e-6);
}

TEST(SurfaceMaterial, WithoutACoatIsLambert) {
  const SurfaceMaterial grey(glm::vec3(0.5f), nullptr, at_cosine(0.7));
  EXPECT_FLOAT_EQ(grey.value(at_cosine(0.4)).y, static_cast<float>(0.5 * 0.4 / pi));
  EXPECT_EQ(grey.value({0, 0.6f, -0.8f}), glm::vec3(0.0f));
  EXPECT_EQ(grey.albedo(), glm::vec3(0.5f));
}

}  // namespace
}  // namespace tress::integrate
