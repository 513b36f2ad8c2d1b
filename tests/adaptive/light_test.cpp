// Rows by the light that they carry: who is created first, how well each is learned, and what the table says of its
// bias.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <thread>
#include <vector>

#include "adaptive/drive_service.h"
#include "adaptive/toy_target.h"
#include "tress/adaptive/cache.h"
#include "tress/adaptive/service.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr std::uint64_t paths = 1000;  // a pass

Options light_driven(double picture_error) {
  Options options;
  options.picture_error = picture_error;
  return options;
}

/// Asks node (a, b) `queries` times, by uniform azimuths, with `share` of the light of the pass in all.
void ask_node(const Service& service, SliceId slice, std::uint32_t a, std::uint32_t b, int queries, float share) {
  RandomStream random(5, a, b);
  for (int i = 0; i < queries; ++i) {
    const RowView row = service.look_up(slice, a, b);
    service.credit(row, share * static_cast<float>(paths) / static_cast<float>(queries));
    if (row.state == RowState::converged) continue;
    const float u = service.options().uniform_share_open, x = row.sample(random.next(), u);
    service.score(row, x, row.nodes->density(x), row.proposal_density(x, u));
  }
}

TEST(Light, DecidesWhoIsBornFirst) {
  const testing::MovingPeaks target;
  Options options;
  options.memory_bytes = 20000;  // for a few rows of the eight
  Service service(options, target);
  const SliceId slice = *service.add_slice(testing::toy_slice(1, 8));
  // The more light, the fewer queries.
  for (std::uint32_t b = 0; b < 8; ++b)
    ask_node(service, slice, 0, b, 40 - 4 * static_cast<int>(b), 0.001f * static_cast<float>(b + 1));
  const PassReport report = service.publish(paths);
  ASSERT_TRUE(report.at_ceiling);
  ASSERT_GE(report.creations, 1u);
  ASSERT_LT(report.creations, 8u);
  for (std::uint32_t b = 0; b < 8; ++b) {
    EXPECT_EQ(service.peek(slice, 0, b).state != RowState::absent, b >= 8 - report.creations) << b;
  }
}

TEST(Light, DecidesHowWellARowIsLearned) {
  const testing::MovingPeaks target;
  Service service(light_driven(0.01), target);
  const SliceId slice = *service.add_slice(testing::toy_slice(1, 4));
  const std::vector<float> shares{1.0f, 0.05f, 1e-6f};
  for (int pass = 0; pass < 30; ++pass) {
    for (std::uint32_t a = 0; a < shares.size(); ++a) ask_node(service, slice, a, 0, 60, shares[a]);
    const PassReport report = service.publish(paths);
    if (pass == 0) {
      EXPECT_EQ(report.newly_converged, 1u) << "what carries nothing is not learned";
    }
  }
  const RowView bright = service.peek(slice, 0, 0), middle = service.peek(slice, 1, 0),
                faint = service.peek(slice, 2, 0);
  EXPECT_EQ(bright.state, RowState::converged);
  EXPECT_LE(bright.objective, 1e-3f);
  EXPECT_EQ(middle.state, RowState::converged);
  EXPECT_GT(middle.objective, bright.objective);
  EXPECT_LT(middle.objective, 1.0f);
  EXPECT_EQ(faint.state, RowState::converged);
  EXPECT_EQ(faint.objective, 1.0f);
  ASSERT_NE(faint.fit, nullptr);
  EXPECT_EQ(faint.fit->component_count, 0u);
  EXPECT_GT(bright.fit->component_count, middle.fit->component_count);
  // Its mean, with the attributes of its rays: the light that it scatters is right, and so is its color.
  EXPECT_NEAR(faint.fit->uniform_weight, 0.8f, 1e-5f);
  EXPECT_GT(Mixture(*faint.fit).uniform_attribute_mean, 1.0f);
  EXPECT_LT(Mixture(*faint.fit).uniform_attribute_mean, 3.0f);
}

TEST(Light, IsOffUnlessAskedFor) {
  const testing::MovingPeaks target;
  std::vector<std::string> tables;
  for (const float share : {0.0f, 0.5f}) {
    Service service(Options{}, target);
    const SliceId slice = *service.add_slice(testing::toy_slice(1, 4));
    for (int pass = 0; pass < 6; ++pass) {
      for (std::uint32_t a = 0; a < 4; ++a) ask_node(service, slice, a, 1, 40, share);
      service.publish(paths);
    }
    tables.push_back(encode_cache(service.snapshot()));
  }
  EXPECT_EQ(tables[0], tables[1]);
}

/// Slices of unequal light, asked from threads in any order.
struct Learned {
  std::string table;
  double bias_bound;
  std::uint64_t g_evaluations = 0, bytes = 0;
};
Learned learn(unsigned threads) {
  const tbb::global_control width(tbb::global_control::max_allowed_parallelism, threads);
  const testing::MovingPeaks target;
  Service service(light_driven(0.02), target);
  for (std::uint32_t p = 0; p < 3; ++p) service.add_slice(testing::toy_slice(p, 8));
  Learned learned;
  for (std::uint64_t pass = 0; pass < 5; ++pass) {
    testing::run_pass(service, 3, pass, 4000, threads);
    std::vector<std::thread> workers;
    for (unsigned w = 0; w < threads; ++w) {
      workers.emplace_back([&, w] {
        for (std::uint32_t i = w; i < 4000; i += threads) {
          const std::uint32_t slice = i % 3, node = i % 64;
          service.credit(service.peek(slice, node / 8, node % 8),
                         (slice == 2 ? 1e-5f : 0.01f) * static_cast<float>(1 + i % 7));
        }
      });
    }
    for (std::thread& worker : workers) worker.join();
    const PassReport report = service.publish(paths);
    learned.g_evaluations += report.g_evaluations;
    learned.bias_bound = report.bias_bound;
    learned.bytes = report.bytes;
  }
  learned.table = encode_cache(service.snapshot());
  return learned;
}

TEST(Light, ThreadsAndOrderChangeNoBit) {
  const Learned one = learn(1);
  EXPECT_GT(one.bias_bound, 0);
  for (const unsigned threads : {2u, 8u}) {
    const Learned many = learn(threads);
    EXPECT_EQ(one.table, many.table);
    EXPECT_EQ(one.bias_bound, many.bias_bound);
    EXPECT_EQ(one.g_evaluations, many.g_evaluations);
    EXPECT_EQ(one.bytes, many.bytes);
  }
}

// By hand: the sum of share sqrt(V o), V = sqrt(pi)/blur at this energy, o = 1 of a row that is not fitted.
TEST(Light, BoundsWhatItsRowsMayDoToThePicture) {
  const testing::MovingPeaks target;
  Service service(light_driven(0.01), target);
  const SliceId slice = *service.add_slice(testing::toy_slice(1, 4));
  ask_node(service, slice, 2, 0, 60, 1e-6f);
  EXPECT_LT(service.publish(paths).bias_bound, 1e-5);
  // Half of the light of the second pass: a quarter of all.
  service.credit(service.peek(slice, 2, 0), 0.5f * static_cast<float>(paths));
  const double expected = 0.25 * std::sqrt(std::sqrt(std::numbers::pi) / 0.2);
  EXPECT_NEAR(service.publish(paths).bias_bound, expected, 1e-3 * expected);
}

/// Learns node (0, 0) with much light and (1, 0) with little.
TableSnapshot taught(double picture_error, float bright, float faint) {
  const testing::MovingPeaks target;
  Service service(light_driven(picture_error), target);
  const SliceId slice = *service.add_slice(testing::toy_slice(1, 4));
  for (int pass = 0; pass < 30; ++pass) {
    ask_node(service, slice, 0, 0, 60, bright);
    ask_node(service, slice, 1, 0, 60, faint);
    service.publish(paths);
  }
  EXPECT_EQ(service.peek(slice, 0, 0).state, RowState::converged);
  EXPECT_EQ(service.peek(slice, 1, 0).state, RowState::converged);
  return service.snapshot();
}

TEST(Light, ACacheOfOneErrorServesAnother) {
  const testing::MovingPeaks target;
  const TableSnapshot image = taught(0.05, 1.0f, 1e-6f);
  ASSERT_LE(image.slices.at(0).rows.at(0).objective, 0.01f);
  ASSERT_EQ(image.slices.at(0).rows.at(1).objective, 1.0f);

  for (const float share : {0.3f, 1e-6f}) {
    Service service(light_driven(0.01), target);
    const SliceId slice = *service.add_slice(testing::toy_slice(1, 4));
    ASSERT_FALSE(service.load(image));
    EXPECT_EQ(service.peek(slice, 0, 0).state, RowState::converged) << "good enough for any light";
    EXPECT_EQ(service.peek(slice, 1, 0).state, RowState::absent) << "nothing is known of its light yet";
    EXPECT_EQ(encode_cache(service.snapshot()), encode_cache(image)) << "nothing is lost meanwhile";
    ask_node(service, slice, 1, 0, 60, share);
    const PassReport report = service.publish(paths);
    EXPECT_EQ(service.peek(slice, 1, 0).state, share > 0.1f ? RowState::open : RowState::converged);
    EXPECT_EQ(report.rows_reopened, 0u);
    for (int pass = 0; pass < 30; ++pass) {
      ask_node(service, slice, 1, 0, 60, share);
      service.publish(paths);
    }
    EXPECT_EQ(service.peek(slice, 1, 0).state, RowState::converged);
    EXPECT_LE(service.peek(slice, 1, 0).objective, share > 0.1f ? 0.013f : 1.0f);
  }
  // And without the knob every row has to reach epsilon, as ever.
  Service uniform(Options{}, target);
  const SliceId slice = *uniform.add_slice(testing::toy_slice(1, 4));
  ASSERT_FALSE(uniform.load(image));
  EXPECT_EQ(uniform.peek(slice, 0, 0).state, RowState::converged);
  EXPECT_EQ(uniform.peek(slice, 1, 0).state, RowState::open);
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
