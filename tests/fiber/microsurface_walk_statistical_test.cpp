// The walk through a microsurface: what it is made of against integrals, and the whole by reciprocity. Seeds are fixed;
// each test's family level is the chance that right code fails it, over the choice of the seed.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

#include "fiber/microsurface_walk.h"
#include "support/chi_square.h"
#include "support/scale.h"
#include "support/seed.h"
#include "tress/base/random.h"

namespace {

using namespace tress;
using fiber::Beckmann;

const glm::vec3 up(0, 0, 1);
constexpr double pi = std::numbers::pi;

glm::vec3 direction(double theta, double phi) {
  return {float(std::sin(theta) * std::cos(phi)), float(std::sin(theta) * std::sin(phi)), float(std::cos(theta))};
}

// Above the horizon 1/(1 + Lambda) is G1; Lambda(-w) = -1 - Lambda(w).
TEST(MicrosurfaceWalk, LambdaIsThatOfTheMaskingFunction) {
  for (const float alpha : {0.05f, 0.3f, 1.0f}) {
    const Beckmann facets(alpha);
    for (const float cosine : {0.01f, 0.1f, 0.3f, 0.7f, 0.95f}) {
      EXPECT_NEAR(1 / (1 + facets.lambda(cosine)), facets.unmasked(cosine), 2e-6f);
      const float sum = facets.lambda(cosine) + facets.lambda(-cosine) + 1;
      EXPECT_NEAR(sum, 0, 2e-6f * (1 + facets.lambda(cosine)));
    }
  }
}

// The slope along w of the facets that light from below the horizon meets, against its density (c - x) e^{-x^2}.
// Seed 1, family level 1e-4 over 8 tests of 40 bins.
TEST(MicrosurfaceWalk, FacetsSeenFromBelowAreDistributedAsTheirProjectedArea) {
  constexpr int bins = 40;
  const int samples = test::scaled(40000);
  const std::vector<double> cs{-0.02, -0.3, -0.9, -1.1, -2.0, -4.0, -12.0, 0.2};
  for (const double c : cs) {
    const float alpha = 0.4f;
    const double theta = std::atan2(1.0, c * double(alpha));  // cot(theta) = c alpha
    const glm::vec3 w = direction(theta, 0);
    const double low = c - 6 / (1 + std::abs(c)), width = (c - low) / bins;
    std::vector<double> expected(bins + 1), counts(bins + 1);
    double mass = 0;
    constexpr int fine = 4000;
    for (int i = 0; i < bins * fine / 10; ++i) {
      const double x = low + (c - low) * (i + 0.5) / (bins * fine / 10);
      const double density = (c - x) * std::exp(-(x * x - c * c));
      expected[std::size_t((x - low) / width)] += density;
      mass += density;
    }
    for (double x = low - 20; x < low; x += 1e-3) {
      const double density = (c - x) * std::exp(-(x * x - c * c)) * 1e-3 / ((c - low) / (bins * fine / 10));
      expected[bins] += density;
      mass += density;
    }
    for (double& count : expected) count *= samples / mass;
    RandomStream random(test::seed(1), std::uint64_t(std::llround(100 + 10 * c)));
    for (int i = 0; i < samples; ++i) {
      const glm::vec3 m = Beckmann(alpha).visible_normal_within(w, up, {random.next(), random.next()}, random);
      const double x = -double(m.x / m.z) / double(alpha);  // slope along w, in alphas
      counts[x < low ? bins : std::min<std::size_t>(bins - 1, std::size_t((x - low) / width))] += 1;
    }
    const auto found = test::chi_square(counts, expected);
    EXPECT_GT(found.p_value, test::sidak_level(1e-4, cs.size())) << "c " << c;
  }
}

// Light that fills the half space sends as much from A to B as from B to A; across the interface, n^2 times as much
// fills the denser side. Seeds 2 and 3, family level 1e-4 over all pairs of bins.
TEST(MicrosurfaceWalk, IsReciprocal) {
  constexpr float eta = 1.55f;
  constexpr int samples = 150000, rings = 4, sectors = 3;
  for (const float alpha : {0.2f, 0.8f}) {
    const Beckmann facets(alpha);
    const auto bin_of = [](const glm::vec3& w) {
      const int ring = std::min(rings - 1, int(rings * (1 - std::abs(w.z))));
      return ring * sectors + std::min(sectors - 1, int(sectors * (std::atan2(w.y, w.x) + pi) / (2 * pi)));
    };
    // counts[from inside][from][refracted][to]
    std::map<std::array<int, 4>, double> counts;
    for (const int inside : {0, 1}) {
      RandomStream random(test::seed(2 + std::uint64_t(inside)), std::uint64_t(100 * alpha));
      for (int i = 0; i < samples; ++i) {
        const float cosine = std::sqrt(1 - random.next());
        const glm::vec3 w = direction(std::acos(double(cosine)), 2 * pi * random.next());
        const auto leaves = fiber::walk_microsurface(facets, inside ? 1 / eta : eta, w, up,
                                                     {random.next(), random.next()}, random.next(), random);
        ASSERT_NEAR(glm::dot(leaves.direction, leaves.direction), 1, 1e-5);
        ASSERT_EQ(leaves.refracted, leaves.direction.z < 0);
        counts[{inside, bin_of(w), leaves.refracted, bin_of(leaves.direction)}] += 1;
      }
    }
    std::vector<double> p_values;
    for (int a = 0; a < rings * sectors; ++a) {
      for (int b = 0; b < rings * sectors; ++b) {
        for (const int inside : {0, 1}) {
          const double there = counts[{inside, a, 0, b}], back = counts[{inside, b, 0, a}];
          if (a < b && there + back > 50) {
            p_values.push_back(test::z_test(there, back, std::sqrt(there + back)));
          }
        }
        const double in = counts[{0, a, 1, b}], out = counts[{1, b, 1, a}], n2 = double(eta * eta);
        if (in + out > 50) p_values.push_back(test::z_test(in, n2 * out, std::sqrt(in + n2 * n2 * out)));
      }
    }
    ASSERT_GT(p_values.size(), 100u);
    for (const double p : p_values) EXPECT_GT(p, test::sidak_level(5e-5, p_values.size())) << "alpha " << alpha;
  }
}

// What an outlook sees of uniform directions is what departs: by bin of the sphere, within 5 standard errors of both
// (some 300 bins: 2e-4; with 400 departures a bin is bright enough for a normal law), and
// altogether all light. Seed 5.
TEST(MicrosurfaceWalk, AnOutlookHasTheDensityOfDepartures) {
  constexpr int rings = 8, sectors = 6, bins = rings * sectors;
  const auto bin_of = [](const glm::vec3& w) {
    const int ring = std::clamp(int(rings * (w.z + 1) / 2), 0, rings - 1);
    return std::size_t(ring * sectors +
                       std::clamp(int(sectors * (std::atan2(w.y, w.x) + pi) / (2 * pi)), 0, sectors - 1));
  };
  const int samples = test::scaled(200000);
  for (const float alpha : {0.2f, 1.0f}) {
    const Beckmann facets(alpha);
    for (const float index : {1.55f, 1 / 1.55f, 1.3f}) {
      for (const double theta : {0.3, 1.4}) {
        RandomStream random(test::seed(5), std::uint64_t(100 * alpha + 10 * index), std::uint64_t(10 * theta));
        const glm::vec3 w = direction(theta, 0.4);
        std::array<double, bins> departs{}, sum{}, square{};
        for (int i = 0; i < samples; ++i) {
          const auto leaves =
              fiber::walk_microsurface(facets, index, w, up, {random.next(), random.next()}, random.next(), random);
          departs[bin_of(leaves.direction)] += 1.0 / samples;
        }
        for (int i = 0; i < samples; ++i) {
          const float z = 2 * random.next() - 1;
          fiber::Outlook outlook{direction(std::acos(double(z)), 2 * pi * double(random.next())), z < 0};
          fiber::split_microsurface(facets, index, w, up, {random.next(), random.next()}, random, outlook);
          const double value = 4 * pi * double(outlook.density);
          sum[bin_of(outlook.direction)] += value / samples;
          square[bin_of(outlook.direction)] += value * value / samples;
        }
        double all = 0, variance = 0;
        for (std::size_t b = 0; b < bins; ++b) {
          const double own = (square[b] - sum[b] * sum[b]) / samples;
          all += sum[b];
          variance += own;
          if (departs[b] * samples < 400) continue;
          EXPECT_NEAR(sum[b], departs[b], 5 * std::sqrt(own + departs[b] / samples))
              << "alpha " << alpha << " index " << index << " theta " << theta << " bin " << b;
        }
        EXPECT_NEAR(all, 1, 5 * std::sqrt(variance));
      }
    }
  }
}

// A smooth surface is a mirror with Fresnel's share. 5 standard errors: 6e-7 false alarms.
TEST(MicrosurfaceWalk, TendsToTheSmoothSurface) {
  const Beckmann facets(0.001f);
  RandomStream random(test::seed(4));
  constexpr int samples = 20000;
  int reflected = 0;
  for (int i = 0; i < samples; ++i) {
    const glm::vec3 w = direction(0.9, 0.4);
    const auto leaves =
        fiber::walk_microsurface(facets, 1.5f, w, up, {random.next(), random.next()}, random.next(), random);
    if (leaves.refracted) continue;
    ++reflected;
    EXPECT_NEAR(glm::dot(leaves.direction, glm::vec3(-w.x, -w.y, w.z)), 1, 1e-4);
  }
  const double ci = std::cos(0.9), ct = std::sqrt(1 - std::sin(0.9) * std::sin(0.9) / 2.25);
  const double rs = (ci - 1.5 * ct) / (ci + 1.5 * ct), rp = (1.5 * ci - ct) / (1.5 * ci + ct);
  const double share = 0.5 * (rs * rs + rp * rp);
  EXPECT_NEAR(double(reflected) / samples, share, 5 * std::sqrt(share / samples));
}

}  // namespace
