#include "fiber/rough_paths.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace {

using namespace tress;
using fiber::FiberParameters;

constexpr fiber::SplitRules rules{0.25f, 1e30f};

/// One fiber with all that a path can meet, one that light crosses straight.
std::vector<FiberParameters> fibers() {
  FiberParameters fiber;
  fiber.eccentricity = 0.75f;
  fiber.roughness = 0.2f;
  fiber.tilt = 0.05236f;
  std::vector<FiberParameters> both{fiber};
  fiber::TracedParts{0.7f, 4, 0.4f, 0.1f, 0.5f, -0.2f, 0.5f}.give_to(fiber);
  both.push_back(fiber);
  return both;
}

/// Path, order, weight, way and direction, in an order that depends on nothing else.
using Exits = std::vector<std::array<float, 7>>;

void append(const fiber::RoughPathExits& exits, Exits& to) {
  for (std::size_t i = 0; i < exits.size(); ++i) {
    const glm::vec3 w = exits.direction(i);
    to.push_back({static_cast<float>(exits.path(i)), static_cast<float>(exits.order(i)), exits.weight(i), exits.way(i),
                  w.x, w.y, w.z});
  }
}

Exits traced(const FiberParameters& parameters, std::uint32_t paths, std::uint32_t at_once) {
  Exits all;
  for (std::uint32_t first = 0; first < paths; first += at_once) {
    fiber::RoughPaths wave(parameters, rules);
    wave.add_sobol({0.5236f, 0.7f}, 1, first, std::min(at_once, paths - first), 0);
    append(wave.trace(), all);
  }
  std::sort(all.begin(), all.end());
  return all;
}

double largest_azimuth_error(const fiber::RoughPathExits& exits, float phi, const std::vector<float>& azimuths) {
  double largest = 0;
  for (std::size_t i = 0; i < exits.size(); ++i) {
    const glm::dvec3 w = exits.direction(i);
    const double off = std::atan2(w.z, w.y) - static_cast<double>(phi) - static_cast<double>(azimuths[i]);
    largest = std::max(largest, std::abs(std::sin(off / 2)) * 2 * std::hypot(w.y, w.z));
  }
  return largest;
}

// Vectors of 4, 8 and 16 lanes, full and not: what becomes of a path is its own, and on machines that fuse additions
// the same bits.
TEST(RoughPaths, PathsAreTheirOwnOnEveryInstructionSet) {
  constexpr std::uint32_t paths = 4096;
  for (const FiberParameters& parameters : fibers()) {
    Exits fused;
    double energy = 0;
    for (std::int64_t left = hwy::SupportedTargets() & HWY_TARGETS; left != 0; left &= left - 1) {
      const std::int64_t target = left & -left;
      hwy::SetSupportedTargetsForTest(target);
      const Exits whole = traced(parameters, paths, paths);
      for (const std::uint32_t at_once : {128u, 37u, 1u}) {
        EXPECT_EQ(whole, traced(parameters, paths, at_once)) << hwy::TargetName(target) << ' ' << at_once;
      }
      double sum = 0;
      for (const auto& exit : whole) sum += static_cast<double>(exit[2]) / paths;
      if (energy == 0) energy = sum;
      EXPECT_NEAR(sum, energy, 0.01) << hwy::TargetName(target);  // of few paths rounding changes a choice
      if (target == HWY_AVX2 || target == HWY_AVX3) {
        if (fused.empty()) fused = whole;
        EXPECT_EQ(whole, fused) << hwy::TargetName(target);
      }
    }
    hwy::SetSupportedTargetsForTest(0);
  }
}

// A path that is added with its numbers, and a set beside another.
TEST(RoughPaths, SetsAndIndicesAreRecorded) {
  const FiberParameters parameters = fibers()[0];
  const fiber::RoughFiber rough(parameters);
  fiber::RoughPaths wave(parameters, rules);
  const fiber::RoughFiber::FacetNumbers u{{{0.1f, 0.2f}, {0.3f, 0.4f}, {0.5f, 0.6f}}};
  wave.add(rough.entry({0.2f, 0.1f}, 0.3f), u, 17, 123456, 15);
  wave.add_sobol({0.5f, 0.7f}, 1, 10, 5, 3);
  const fiber::RoughPathExits& exits = wave.trace();
  std::size_t alone = 0;
  for (std::size_t i = 0; i < exits.size(); ++i) {
    if (exits.set(i) == 15) {
      ++alone;
      EXPECT_EQ(exits.path(i), 123456u);
    } else {
      EXPECT_EQ(exits.set(i), 3u);
      EXPECT_TRUE(exits.path(i) >= 10 && exits.path(i) < 15) << exits.path(i);
    }
  }
  EXPECT_GT(alone, 0u);
  EXPECT_EQ(wave.trace().size(), 0u);
}

TEST(RoughPaths, PlacesAreThoseOfLibm) {
  fiber::RoughPaths wave(fibers()[0], rules);
  wave.add_sobol({0.5f, 0.7f}, 1, 0, 4096, 0);
  const fiber::RoughPathExits& exits = wave.trace();
  std::vector<float> azimuths, heights;
  exits.places(std::cos(0.7f), std::sin(0.7f), 12, azimuths, heights);
  ASSERT_EQ(azimuths.size(), exits.size());
  EXPECT_LT(largest_azimuth_error(exits, 0.7f, azimuths), 1e-6);
  for (std::size_t i = 0; i < exits.size(); ++i) {
    const glm::dvec3 w = exits.direction(i);
    const double across = std::hypot(w.y, w.z), height = std::asinh(w.x / across);
    EXPECT_NEAR(static_cast<double>(heights[i]), std::clamp(height, -12.0, 12.0), 1e-6 + 3e-7 / across);
    EXPECT_NEAR(glm::length(w), 1, 1e-6);
  }
}

TEST(RoughPaths, ExtremeFibersAreFinite) {
  for (const float e : {0.3f, 1.0f}) {
    for (const float alpha : {1e-4f, 1.0f}) {
      for (const float eta : {1.05f, 3.0f}) {
        for (const float tilt : {0.0f, 0.5f}) {
          FiberParameters parameters;
          parameters.eccentricity = e;
          parameters.roughness = alpha;
          parameters.eta = eta;
          parameters.tilt = tilt;
          for (const float theta : {0.0f, 1.5f, 1.5707963f}) {
            fiber::RoughPaths wave(parameters, rules);
            wave.add_sobol({theta, 1.5707963f}, 1, 0, 256, 0);
            const fiber::RoughPathExits& exits = wave.trace();
            double sum = 0;
            for (std::size_t i = 0; i < exits.size(); ++i) {
              EXPECT_NEAR(glm::length(exits.direction(i)), 1, 1e-5f);
              EXPECT_TRUE(exits.way(i) >= 0 && std::isfinite(exits.way(i)));
              EXPECT_TRUE(exits.weight(i) > 0 && exits.weight(i) <= 1.000001f);
              sum += static_cast<double>(exits.weight(i)) / 256;
            }
            EXPECT_NEAR(sum, 1, 0.15) << e << ' ' << alpha << ' ' << eta << ' ' << tilt << ' ' << theta;
          }
        }
      }
    }
  }
}

}  // namespace
