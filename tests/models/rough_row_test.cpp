// A converged row of the rough fiber under a color: in lanes what the ribbons are, drawn as it is evaluated.
#include "models/rough/rough_row.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <vector>

#include "adaptive/random_ribbons.h"
#include "models/rough/rough_lanes.h"
#include "support/chi_square.h"
#include "support/quadrature.h"
#include "tress/base/random.h"

namespace tress {
namespace {

using adaptive::Ribbon;
using adaptive::RibbonKnot;
using adaptive::RibbonRow;
using fiber::RoughRow;

constexpr double pi = std::numbers::pi;
const glm::vec3 brown(0.3f, 0.9f, 4);

RibbonRow random_row(std::uint64_t seed, bool rough) {
  std::array<RibbonRow::Part, RibbonRow::most_parts> parts;
  for (std::size_t p = 0; p < parts.size(); ++p)
    parts[p] = {adaptive::random_ribbon(4 * seed + p / 2, rough), 0.1f + 0.2f * static_cast<float>(p)};
  return RibbonRow(parts);
}

struct Colored {
  Colored(const RibbonRow& row, const glm::vec3& sigma_a) : memory(std::make_unique<RoughRow>()) {
    put_rough_row(adaptive::DecodedRow(row), 0.01f, 512, fiber::ColoredDecays(sigma_a), {}, memory.get());
  }
  const RoughRow& operator*() const { return *memory; }
  std::unique_ptr<RoughRow> memory;
};

/// The ribbon that one channel sees, of mass 1: the definition, by the ribbon's own means.
Ribbon colored(const Ribbon& ribbon, float sigma_a) {
  const auto decayed = [&](const RibbonKnot& knot) {
    RibbonKnot made = knot;
    made.density *= adaptive::GammaDecay::from(knot.decays).at(sigma_a);
    return made;
  };
  std::array<RibbonKnot, Ribbon::main_knots> main;
  std::array<RibbonKnot, Ribbon::broad_knots> broad;
  std::ranges::transform(ribbon.main(), main.begin(), decayed);
  std::ranges::transform(ribbon.broad(), broad.begin(), decayed);
  return Ribbon(main, ribbon.main_law(), broad);
}

// Densities in 65535 steps and azimuths in 65536ths of a turn: within 2e-3 of the largest nearby.
TEST(RoughRow, IsTheRibbonsUnderEachChannel) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const RibbonRow row = random_row(seed, false);
    const Colored in_lanes(row, brown);
    RandomStream random(seed);
    for (int c = 0; c < 3; ++c) {
      for (std::uint32_t p = 0; p < row.parts(); ++p) {
        const Ribbon ribbon = colored(row.ribbon(p), brown[c]);
        double squares = 0, errors = 0;
        for (int i = 0; i < 400; ++i) {
          const auto x = static_cast<float>(2 * pi * random.next() - pi);
          const float t = 3 * random.next() - 1.5f;
          const auto f = part_densities(*in_lanes, x, t);
          const double expected = double{ribbon.density(x, t)}, found = double{f[p][c]};
          squares += expected * expected;
          errors += (found - expected) * (found - expected);
        }
        EXPECT_LT(std::sqrt(errors / squares), 2e-3) << "seed " << seed << " part " << p << " channel " << c;
      }
    }
  }
}

// By 256 azimuths and 3000 heights from -9 to 9, of laws of scales of 0.02 and more: five midpoints a scale. Densities
// are not smooth between knots: 4e-3.
TEST(RoughRow, HasMassOneInEachPartAndChannel) {
  const RibbonRow row = random_row(9, false);
  for (const glm::vec3& sigma_a : {glm::vec3(0.0f), brown, glm::vec3(0, 50, 1e4f)}) {
    const Colored in_lanes(row, sigma_a);
    constexpr int azimuths = 256, heights = 3000;
    std::array<glm::dvec3, 4> mass{};
    for (int i = 0; i < azimuths; ++i) {
      const auto x = static_cast<float>(-pi + 2 * pi * (i + 0.5) / azimuths);
      for (int k = 0; k < heights; ++k) {
        const auto f = part_densities(*in_lanes, x, static_cast<float>(-9 + 18 * (k + 0.5) / heights));
        for (std::size_t p = 0; p < 4; ++p) mass[p] += glm::dvec3(f[p][0], f[p][1], f[p][2]);
      }
    }
    for (std::size_t p = 0; p < 4; ++p) {
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(mass[p][c] * 2 * pi / azimuths * 18 / heights, 1, 4e-3) << p << ' ' << c;
    }
  }
}

// The Rosenblatt transform of what is drawn is uniform in the unit square. Six tests, false alarms 1e-4 in all (Sidak).
TEST(RoughRow, DrawsTheMixOfItsChannels) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const RibbonRow row = random_row(seed, seed == 3);
    const Colored in_lanes(row, brown);
    for (const int channel : {0, 2}) {
      const std::uint32_t p = channel == 0 ? 1 : 3;
      const Ribbon ribbon = colored(row.ribbon(p), brown[channel]);
      glm::vec3 weights(0.0f);
      weights[channel] = 1;
      constexpr int bins = 16, draws = 20000;
      std::vector<double> counts(bins * bins), expected(bins * bins, double{draws} / (bins * bins));
      RandomStream random(seed);
      for (int i = 0; i < draws; ++i) {
        const float u1 = random.next(), u2 = random.next();
        const fiber::RowPlace place =
            draw_place((*in_lanes).part[p], (*in_lanes).is_normal[static_cast<int>(p)] != 0, weights, u1, u2);
        ASSERT_GE(place.azimuth, -3.1415927f);
        ASSERT_LT(place.azimuth, 3.1415927f);
        const std::array<float, 2> at = ribbon.cdf(place.azimuth, place.height);
        const auto bin = [](float u) { return std::clamp(static_cast<int>(u * bins), 0, bins - 1); };
        ++counts[static_cast<std::size_t>(bin(at[0]) * bins + bin(at[1]))];
      }
      EXPECT_GT(test::chi_square(counts, expected).p_value, test::sidak_level(1e-4, 6)) << seed << ' ' << channel;
    }
  }
}

TEST(RoughRow, IsFiniteAtTheBoundsOfRibbons) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const RibbonRow row = random_row(seed, true);
    // Between them layers are left whose light is no normal number.
    for (const glm::vec3& sigma_a :
         {glm::vec3(0.0f), brown, glm::vec3(30, 60, 90), glm::vec3(130, 200, 400), glm::vec3(1e4f)}) {
      const Colored in_lanes(row, sigma_a);
      RandomStream random(seed);
      for (int i = 0; i < 200; ++i) {
        const float u = i == 0 ? 0 : i == 1 ? 0.99999994f : random.next(), v = i == 2 ? 0 : random.next();
        const std::size_t p = static_cast<std::size_t>(i) % 4;
        const fiber::RowPlace place =
            draw_place((*in_lanes).part[p], (*in_lanes).is_normal[static_cast<int>(p)] != 0, glm::vec3(1.0f / 3), u, v);
        ASSERT_TRUE(std::isfinite(place.height) && std::abs(place.azimuth) <= 3.1415927f) << seed;
        const auto f = part_densities(*in_lanes, place.azimuth, place.height);
        for (const Float4& density : f) {
          for (int c = 0; c < 4; ++c) ASSERT_TRUE(std::isfinite(density[c]) && density[c] >= 0) << seed;
        }
      }
    }
  }
}

// Heights and inclinations are each other's inverse to a few digits of a float, up to 89.99 degrees.
TEST(RoughRow, KnowsHeights) {
  for (float theta = -1.5706f; theta < 1.5707f; theta += 0.001f) {
    const fiber::AxialPlace place(theta);
    EXPECT_NEAR(place.height, std::asinh(std::tan(double{theta})), 1e-6 + 2e-7 / std::cos(double{theta}));
    EXPECT_NEAR(fiber::inclination_of_height(place.height), theta, 1e-6f);
  }
  EXPECT_TRUE(std::isfinite(fiber::AxialPlace(0.5f * std::numbers::pi_v<float>).height));
}

}  // namespace
}  // namespace tress
