#include "fiber/elliptical_target.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "fiber/direct_energies.h"
#include "fiber/fourier_reference.h"
#include "fiber/reference_data.h"
#include "tress/adaptive/traced_nodes.h"
#include "tress/fiber/elliptical_model.h"

namespace {

using namespace tress;
using test::degree;

TEST(EllipticalTarget, NodeCountsFollowTheRule) {
  EXPECT_EQ(fiber::traced_node_count(float(45 * degree)), 128);
  EXPECT_EQ(fiber::traced_node_count(float(20 * degree)), 128);
  EXPECT_EQ(fiber::traced_node_count(float(19 * degree)), 256);
  EXPECT_EQ(fiber::traced_node_count(float(10 * degree)), 256);
  EXPECT_EQ(fiber::traced_node_count(float(5 * degree)), 512);
}

TEST(EllipticalTarget, IsTheReferenceRelativeToTheKnownAzimuth) {
  // Its own error must stay below a third of epsilon = 0.01: relative L2 against 32768 nodes, 7.1's measure.
  const fiber::EllipticalTarget target;
  std::vector<adaptive::TracedRay> rays;
  for (int p : {1, 2, 3}) {
    for (double sigma : {5.0, 10.0, 20.0}) {
      for (double phi_r : {0.0, 0.4, 1.2}) {
        for (double theta_d : {0.0, 0.6, 1.3}) {
          const auto slice = fiber::elliptical_slice(p, 1.55f, 0.85f, float(sigma * degree));
          rays.clear();
          target.trace(slice, float(phi_r), float(theta_d), rays);
          const adaptive::TracedNodes nodes(rays, slice.blur_rad);
          fiber::ReferenceRequest request;
          request.theta_d = float(theta_d);
          request.phi_r = float(phi_r);
          request.sigma = slice.blur_rad;
          request.p = p;
          request.eccentricity = 0.85f;
          request.nodes = 32768;
          const fiber::FourierReference reference(request);
          EXPECT_NEAR(nodes.energy(), reference.energy(), 2e-3);
          double difference = 0, variation = 0;
          for (int k = 0; k < 360; ++k) {
            const double x = (k - 180) * degree, n = reference.density(phi_r + x);
            difference += std::pow(nodes.density(float(x)) - n, 2) * degree;
            variation += std::pow(n - reference.energy() / (360 * degree), 2) * degree;
          }
          variation = std::max(variation, 1e-3 / (360 * degree));
          EXPECT_LT(difference / variation, 0.01 / 3) << p << ' ' << sigma << ' ' << phi_r << ' ' << theta_d;
        }
      }
    }
  }
}

TEST(EllipticalTarget, GlintAndTheRestAreTrtPointByPoint) {
  // The parts keep A and Phi of the whole's rays: azimuths to the bit, weights to single precision. Each is also its
  // own reference, as closely as the whole is (relative L2 below a third of epsilon = 0.01).
  const fiber::EllipticalTarget target;
  const float sigma = float(10 * degree);
  for (float e : {0.7f, 0.85f}) {
    for (const auto& [phi_r, theta_d] : {std::array{0.0f, 0.0f}, {0.4f, 0.6f}, {1.2f, 0.9f}}) {
      const auto trace = [&](int lobe) {
        std::vector<adaptive::TracedRay> rays;
        target.trace(fiber::elliptical_slice(lobe, 1.55f, e, sigma), phi_r, theta_d, rays);
        return adaptive::TracedNodes(rays, sigma);
      };
      const auto whole = trace(2), glint = trace(fiber::glint_slice), rest = trace(fiber::trt_rest_slice);
      fiber::ReferenceRequest request;
      request.eccentricity = e;
      request.theta_d = theta_d;
      request.phi_r = phi_r;
      request.sigma = sigma;
      request.p = 2;
      request.nodes = 8192;
      request.part = fiber::TrtPart::glint;
      const fiber::FourierReference glint_reference(request);
      request.part = fiber::TrtPart::rest;
      const fiber::FourierReference rest_reference(request);
      double error = 0;
      for (int k = -180; k < 180; ++k) {
        const double x = k * degree;
        // A weak part is traced with four times the rays: then the whole differs by what its rays are off.
        EXPECT_NEAR(glint.density(float(x)) + rest.density(float(x)), whole.density(float(x)), 2e-3);
        error += (std::pow(glint.density(float(x)) - glint_reference.density(phi_r + x), 2) / glint.variation() +
                  std::pow(rest.density(float(x)) - rest_reference.density(phi_r + x), 2) / rest.variation()) *
                 degree;
      }
      EXPECT_LT(error, 0.01 / 3) << e << ' ' << phi_r << ' ' << theta_d;
      EXPECT_NEAR(glint.energy() + rest.energy(), whole.energy(), 1e-3);
    }
  }
}

TEST(EllipticalTarget, PathLengthsGiveTheColoredEnergies) {
  const fiber::EllipticalTarget target;
  const auto table = test::direct_energies(1.55, 0.85f, glm::vec3(0.5f), 0.4, 0.6, 512, 3);
  for (int p : {1, 2, 3}) {
    std::vector<adaptive::TracedRay> rays;
    target.trace(fiber::elliptical_slice(p, 1.55f, 0.85f, float(5 * degree)), 0.4f, 0.6f, rays);
    double energy = 0;
    for (const auto& ray : rays) energy += ray.weight * std::exp(-0.5 * ray.attribute);
    // 512 or 2048 midpoints here, 512 there: the square-root edges cost some 1e-4.
    EXPECT_NEAR(energy, table.colored[std::size_t(p)].r, 5e-4) << p;
  }
}

TEST(EllipticalTarget, AppendsAndIsPure) {
  const fiber::EllipticalTarget target;
  const auto slice = fiber::elliptical_slice(2, 1.55f, 0.7f, 0.2f);
  std::vector<adaptive::TracedRay> once, twice;
  target.trace(slice, 0.3f, 1.0f, once);
  target.trace(slice, 0.3f, 1.0f, twice);
  target.trace(slice, 0.3f, 1.0f, twice);
  ASSERT_EQ(twice.size(), 2 * once.size());
  for (std::size_t i = 0; i < once.size(); ++i) {
    EXPECT_EQ(once[i].azimuth, twice[once.size() + i].azimuth);
    EXPECT_EQ(once[i].weight, twice[i].weight);
  }
  EXPECT_EQ(target.model_name(), fiber::make_elliptical_target()->model_name());
}

TEST(EllipticalTarget, ExtremeNodesAreFinite) {
  const fiber::EllipticalTarget target;
  for (int p : {1, 2, 3}) {
    for (float eta : {1.05f, 3.0f}) {
      std::vector<adaptive::TracedRay> rays;
      target.trace(fiber::elliptical_slice(p, eta, 0.5f, 0.1f), 0, float(90 * degree), rays);
      for (const auto& ray : rays) {
        EXPECT_TRUE(std::isfinite(ray.azimuth) && std::isfinite(ray.weight) && std::isfinite(ray.attribute));
        EXPECT_GE(ray.weight, 0);
      }
    }
  }
}

}  // namespace
