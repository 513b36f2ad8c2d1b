// A knot table as one color sees it: the shape of each channel has mass 1, and the proposal is what sample() inverts.
#include "references/learners/absorbed_knots.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <numbers>
#include <span>
#include <vector>

#include "references/knot_tables.h"

namespace tress::inline v0_2::fiber {
namespace {

constexpr double pi = std::numbers::pi;
const glm::vec3 brown(0.4f, 0.9f, 1.8f), mix(0.5f, 0.3f, 0.2f);

float angle(int i, int points) { return static_cast<float>(-pi + 2 * pi * (i + 0.5) / points); }

TEST(AbsorbedKnots, ClearHairSeesTheTableItself) {
  for (const std::size_t count : {32u, 64u, 128u}) {
    const adaptive::KnotDensity table = adaptive::rough_table(count, 0.4f, 2);
    const AbsorbedKnots row(table, glm::vec3(0.0f));
    for (int i = 0; i < 500; ++i) {
      const float x = angle(i, 500);
      const RowValue value = row.evaluate(x, mix, 0.02f);
      const float shape = table.density(x) / table.energy();
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(value.shape[c], shape, 1e-5f * (1 + shape)) << count << " " << x;
      EXPECT_NEAR(value.proposal, table.proposal_density(x, 0.02f), 1e-5f * (1 + shape));
    }
  }
}

TEST(AbsorbedKnots, EachChannelHasItsShareOfEachKnotAndMassOne) {
  const adaptive::KnotDensity table = adaptive::rough_table(64, 0.4f, 4);
  const AbsorbedKnots row(table, brown);
  for (int c = 0; c < 3; ++c) {
    double mass = 0;
    std::vector<double> colored(64);
    for (std::size_t k = 0; k < 64; ++k) {
      const adaptive::Knot& knot = table.knots()[k];
      colored[k] = knot.density * adaptive::decayed_share(brown[c], knot.attribute_mean, knot.attribute_variance);
      mass += colored[k] * 2 * pi / 64;
    }
    double total = 0;
    for (int i = 0; i < 64 * 8; ++i) {  // midpoints of parts of cells: exact for straight lines
      const float x = angle(i, 64 * 8);
      const std::size_t k = static_cast<std::size_t>(i) / 8;
      const double along = (i % 8 + 0.5) / 8;
      const double wanted = ((1 - along) * colored[k] + along * colored[(k + 1) % 64]) / mass;
      const double shape = row.evaluate(x, mix, 0.02f).shape[c];
      EXPECT_NEAR(shape, wanted, 2e-5 * (1 + wanted));
      total += shape * 2 * pi / (64 * 8);
    }
    EXPECT_NEAR(total, 1, 1e-5);
  }
}

TEST(AbsorbedKnots, SamplingInvertsTheProposalUnderAnyMixOfChannels) {
  const float share = 0.02f;
  for (const std::size_t count : {32u, 128u}) {
    const AbsorbedKnots row(adaptive::rough_table(count, 0.4f, 6), brown);
    for (const glm::vec3& weights : {mix, glm::vec3(1, 0, 0), glm::vec3(0, 0.25f, 0.75f)}) {
      const int points = static_cast<int>(count) * 16;
      std::vector<double> below(static_cast<std::size_t>(points) + 1, 0.0);  // of the mix, without the uniform share
      for (int i = 0; i < points; ++i) {
        const RowValue value = row.evaluate(angle(i, points), weights, share);
        below[static_cast<std::size_t>(i) + 1] =
            below[static_cast<std::size_t>(i)] + static_cast<double>(glm::dot(weights, value.shape)) * 2 * pi / points;
      }
      for (int i = 0; i < 300; ++i) {
        const float v = (static_cast<float>(i) + 0.5f) / 300;
        const double x = row.sample(v * (1 - share), weights, share);
        const double at = (x + pi) / (2 * pi) * points;
        const auto left = std::min(static_cast<std::size_t>(at), below.size() - 2);
        // Within a sixteenth of a cell the mass is nearly linear: off by an eighth of what its density changes there.
        const double mass = below[left] + (at - static_cast<double>(left)) * (below[left + 1] - below[left]);
        EXPECT_NEAR(mass, v, 2e-4) << count << " knots, v " << v;
      }
    }
    EXPECT_NEAR(row.sample(1 - share / 2, mix, share), 0, 1e-3f);  // the middle of the uniform share
  }
}

TEST(AbsorbedKnots, WeightsAreBoundedAndEveryInputHasAnAnswer) {
  const float share = 0.02f;
  std::vector<adaptive::Knot> spike(32);
  spike[0] = {5, 1, 0.1f};
  for (const adaptive::KnotDensity& table :
       {adaptive::rough_table(64, 1, 8), adaptive::KnotDensity(std::vector<adaptive::Knot>(32)),
        adaptive::KnotDensity(spike)}) {
    for (const glm::vec3& sigma_a : {glm::vec3(0.0f), brown, glm::vec3(0, 1e3f, 1e30f)}) {
      const AbsorbedKnots row(table, sigma_a);
      for (const float u : {0.0f, 1e-30f, 0.3f, 0.5f, 0.97999996f, 0.98f, 0.98000002f, 0.99999994f}) {
        const float x = row.sample(u, mix, share);
        ASSERT_GE(x, -std::numbers::pi_v<float>);
        ASSERT_LT(x, std::numbers::pi_v<float>);
        const RowValue value = row.evaluate(x, mix, share);
        EXPECT_GE(value.proposal, 0.99f * share / (2 * std::numbers::pi_v<float>));
        EXPECT_LE(glm::dot(mix, value.shape) / value.proposal, 1 / (1 - share) + 1e-4f);
      }
      for (const float x : {-std::numbers::pi_v<float>, std::nextafter(std::numbers::pi_v<float>, 0.0f)}) {
        for (int c = 0; c < 3; ++c) EXPECT_TRUE(std::isfinite(row.evaluate(x, mix, share).shape[c]));
      }
    }
  }
}

// No light left in blue: its shape does not matter, and is called uniform.
TEST(AbsorbedKnots, ADarkChannelIsUniform) {
  const AbsorbedKnots row(adaptive::rough_table(32, 1, 1), glm::vec3(0, 0, 1e30f));
  for (int i = 0; i < 50; ++i) EXPECT_NEAR(row.evaluate(angle(i, 50), mix, 0.02f).shape.z, 1 / (2 * pi), 1e-6);
}

TEST(AbsorbedKnots, TakeALineForFourKnots) {
  EXPECT_EQ(AbsorbedKnots(adaptive::rough_table(128, 1, 3), brown).bytes(), 128 / 4 * 64);
}

}  // namespace
}  // namespace tress::inline v0_2::fiber
