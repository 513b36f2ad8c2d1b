// Queries as a whole: what a host would write by look_up(), the mean over nodes, and batches.
#include "tress/adaptive/query.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "adaptive/toy_samples.h"
#include "adaptive/toy_target.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr float pi = std::numbers::pi_v<float>;
const testing::MovingPeaks peaks;
const testing::MovingLobes lobes;

struct Learned {
  /// passes: of 9 nodes of either kind, 100 queries each.
  explicit Learned(int passes) : service(Options{}, peaks, lobes) {
    densities = *service.add_slice(testing::toy_slice(0, 3));
    SliceDescription coarse = testing::sampled_slice(1, 3);
    coarse.coarse = {{{0, 2}, {0, 2}}};
    samples = *service.add_slice(coarse);
    for (int pass = 0; pass < passes; ++pass) {
      for (std::uint32_t node = 0; node < 9; ++node) {
        RandomStream random(3, static_cast<std::uint64_t>(pass), node);
        for (int i = 0; i < 100; ++i) {
          sample(service, {densities, node / 3, node % 3}, {random.next(), 0, 0});
          sample(service, {samples, node / 3, node % 3}, {random.next(), random.next(), random.next()});
        }
      }
      report = service.publish();
    }
  }
  Service service;
  SliceId densities = 0, samples = 0;
  PassReport report;
};

TEST(Query, AtNodesAnswersByRowOrTargetAndTeaches) {
  const Learned cold(0), warm(12);
  EXPECT_GE(warm.report.rows_converged, 9u) << "those of densities";
  for (const Learned* one : {&cold, &warm}) {
    const RowView row = one->service.look_up(one->densities, 1, 2);
    const bool is_fit = row.state == RowState::converged;
    EXPECT_EQ(is_fit, one == &warm);
    const NodeValue value = evaluate(one->service, {one->densities, 1, 2}, 1 + 2 * pi);
    const float share =
        is_fit ? one->service.options().uniform_share_converged : one->service.options().uniform_share_open;
    EXPECT_EQ(value.azimuth, wrap_angle(1 + 2 * pi));
    EXPECT_EQ(value.density, is_fit ? row.density(value.azimuth) : row.nodes->density(value.azimuth));
    EXPECT_EQ(value.pdf, row.proposal_density(value.azimuth, share));
    EXPECT_TRUE(value.answered);
    EXPECT_FLOAT_EQ(pdf(one->service, {one->densities, 1, 2}, 1 + 2 * pi), value.pdf);
    EXPECT_EQ(pdf(one->service, {one->samples, 1, 2}, 1, 0.5f),
              evaluate(one->service, {one->samples, 1, 2}, 1, 0.5f).pdf);
    const NodeValue drawn = sample(one->service, {one->densities, 1, 2}, {0.3f, 0, 0});
    const NodeValue again = evaluate(one->service, {one->densities, 1, 2}, drawn.azimuth);
    EXPECT_EQ(drawn.azimuth, row.sample(0.3f, share));
    EXPECT_EQ(drawn.density, again.density);
    EXPECT_EQ(drawn.pdf, again.pdf);
  }
  EXPECT_FALSE(evaluate(cold.service, {cold.samples, 1, 1}, 0, 0).answered);
  EXPECT_TRUE(evaluate(warm.service, {warm.samples, 1, 1}, 0, 0).answered);
  EXPECT_EQ(evaluate(cold.service, {7, 1, 1}, 0).density, 0) << "a slice that does not exist";
}

// The places of toy_slice are 1/6, 1/2, 5/6. The sum over 4 x 4 midpoints of xi is exact where shares are 1/4 and 3/4;
// four roundings of values of the order of 1 are 5e-7.
TEST(Query, TheMeanIsThatOverWhatIsChosen) {
  for (const int passes : {0, 1, 12}) {
    const Learned learned(passes);
    for (const SliceId slice : {learned.densities, learned.samples}) {
      const float a = 1.0f / 6 + 0.75f / 3, b = 0.5f + 0.25f / 3;
      if (slice == learned.samples && passes == 0) {
        EXPECT_FALSE(mean(learned.service, slice, a, b, 1).answered);
        EXPECT_FALSE(sample_mean(learned.service, slice, a, b, {}).answered);
        continue;
      }
      for (const float azimuth : {-3.0f, 0.1f, 2.0f}) {
        double density = 0, pdf = 0, last = 0;
        for (int i = 0; i < 16; ++i) {
          const Node node = choose(learned.service, slice, a, b, static_cast<float>(i / 4) / 4 + 0.125f,
                                   static_cast<float>(i % 4) / 4 + 0.125f);
          const NodeValue one = evaluate(learned.service, node, azimuth, 0.2f);
          density += double{one.density} / 16;
          pdf += double{one.pdf} / 16;
          last += double{one.parts[1]} / 16;
        }
        const NodeValue found = mean(learned.service, slice, a, b, azimuth, 0.2f);
        EXPECT_NEAR(double{found.density}, density, 5e-7 + 1e-5 * density) << "the share of 1/4 is rounded";
        EXPECT_NEAR(double{found.pdf}, pdf, 5e-7 + 1e-5 * pdf);
        EXPECT_NEAR(double{found.parts[1]}, last, 5e-7 + 1e-5 * last);
      }
      const NodeValue drawn = sample_mean(learned.service, slice, a, b, {0.4f, 0.3f, 0.6f, 0.1f, 0.9f});
      const NodeValue found = mean(learned.service, slice, a, b, drawn.azimuth, drawn.height);
      EXPECT_EQ(drawn.pdf, found.pdf);
      EXPECT_EQ(drawn.density, found.density);
    }
  }
}

TEST(Query, PlacesBeyondTheAxesAreAtTheirEnds) {
  const Learned learned(1);
  const float nan = std::nanf("");
  const auto at = [&](float a, float b) { return mean(learned.service, learned.densities, a, b, 1).density; };
  EXPECT_EQ(at(-9, 1), at(1.0f / 6, 5.0f / 6));
  EXPECT_EQ(at(9, nan), evaluate(learned.service, {learned.densities, 2, 0}, 1).density);
  const Node last = choose(learned.service, learned.densities, 9, 9, 0.99999994f, nan);
  EXPECT_EQ(last.a, 2u);
  EXPECT_EQ(last.b, 2u);
  EXPECT_EQ(mean(learned.service, 7, 0, 0, 1).density, 0) << "a slice that does not exist";
}

// The trapezoidal rule at 4,096 steps is exact for blurs of 0.2 but for rounding; shares of 0.25 and 0.75 of energies.
TEST(Query, TheMeanIntegratesToTheEnergyOfItsNodes) {
  const Learned learned(12);
  const float a = 1.0f / 6 + 0.75f / 3, b = 0.5f;
  double density = 0, pdf = 0;
  constexpr int steps = 4096;
  for (int i = 0; i < steps; ++i) {
    const NodeValue value = mean(learned.service, learned.densities, a, b, 2 * pi * static_cast<float>(i) / steps);
    density += double{value.density} * 2 * std::numbers::pi / steps;
    pdf += double{value.pdf} * 2 * std::numbers::pi / steps;
  }
  EXPECT_NEAR(density, 0.8, 1e-4) << "a peak loses 0.4 b to the other; rows keep the mass of their rays to 1e-4";
  EXPECT_NEAR(pdf, 1, 1e-5);
}

TEST(Query, BatchesHaveTheBitsOfOneByOne) {
  const Learned one(3), many(3);
  std::vector<Node> nodes;
  std::vector<std::array<float, 3>> u;
  std::vector<std::array<float, 2>> places;
  for (std::uint32_t i = 0; i < 300; ++i) {
    RandomStream random(9, i);
    nodes.push_back({i % 2 == 0 ? one.densities : one.samples, i / 2 % 3, i / 6 % 3});
    u.push_back({random.next(), random.next(), random.next()});
    places.push_back({6 * random.next() - 3, random.next()});
  }
  std::vector<NodeValue> drawn(nodes.size()), lit(nodes.size());
  sample(many.service, nodes, u, drawn);
  evaluate(many.service, nodes, places, lit);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const NodeValue a = sample(one.service, nodes[i], u[i]),
                    b = evaluate(one.service, nodes[i], places[i][0], places[i][1]);
    EXPECT_EQ(a.azimuth, drawn[i].azimuth);
    EXPECT_EQ(a.pdf, drawn[i].pdf);
    EXPECT_EQ(a.parts, drawn[i].parts);
    EXPECT_EQ(b.pdf, lit[i].pdf);
    EXPECT_EQ(b.parts, lit[i].parts);
  }
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
