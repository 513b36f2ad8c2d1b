// Rows of the learner `table` in the service: built at the end of the pass of their first touch, answered by knots,
// saved, loaded, audited and counted as what they are.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "adaptive/drive_service.h"
#include "adaptive/toy_target.h"
#include "tress/adaptive/cache.h"
#include "tress/adaptive/service.h"

namespace tress::adaptive {
namespace {

constexpr std::uint32_t size = 4;
constexpr std::uint32_t nodes = size * size;

Options table_options(double epsilon = 0.01) {
  Options options;
  options.learner = &knot_learner;
  options.epsilon = epsilon;
  return options;
}

PassReport touch_all(Service& service) {
  for (SliceId slice = 0; slice < service.slice_count(); ++slice) {
    for (std::uint32_t n = 0; n < nodes; ++n) service.look_up(slice, n / size, n % size);
  }
  return service.publish();
}

double true_objective(const RowView& row, const Target& target, const SliceDescription& slice, std::uint32_t node) {
  std::vector<TracedRay> rays;
  target.trace(slice, slice.axis_a[node / size], slice.axis_b[node % size], rays);
  const TracedNodes traced(rays, slice.blur_rad);
  constexpr int points = 4096;
  double sum = 0;
  for (int i = 0; i < points; ++i) {
    const auto x = static_cast<float>(-std::numbers::pi + 2 * std::numbers::pi * i / points);
    const double r = static_cast<double>(traced.density(x)) - static_cast<double>(row.density(x));
    sum += r * r * 2 * std::numbers::pi / points;
  }
  return sum / static_cast<double>(traced.variation());
}

TEST(KnotRows, AreBuiltAtTheEndOfThePassOfTheirFirstTouch) {
  const testing::MovingPeaks target;
  Service service(table_options(), target);
  const SliceId slice = *service.add_slice(testing::toy_slice(1, size));
  const RowView before = service.look_up(slice, 1, 2);
  EXPECT_EQ(before.state, RowState::absent);  // the published table does not change during a pass
  ASSERT_NE(before.nodes, nullptr);
  const PassReport report = service.publish();
  EXPECT_EQ(report.creations, 1u);
  EXPECT_EQ(report.newly_converged, 1u);

  const RowView row = service.peek(slice, 1, 2);
  EXPECT_EQ(row.state, RowState::converged);
  EXPECT_EQ(row.fit, nullptr);
  EXPECT_EQ(row.nodes, nullptr);
  ASSERT_NE(row.knots, nullptr);
  const double error = true_objective(row, target, service.slice(slice), 1 * size + 2);
  EXPECT_LE(error, service.options().epsilon);
  EXPECT_NEAR(row.objective, error, 0.2 * error);  // Boole's rule: see fit_knots_test
  // A hat reaches over both bundles of rays, of attributes 1 and 3.
  for (const Knot& knot : row.knots->knots()) {
    EXPECT_GE(knot.attribute_mean, 1 - 1e-5f);
    EXPECT_LE(knot.attribute_mean, 3 + 1e-5f);
  }
}

TEST(KnotRows, TellTheirProposalAndTheirSampleAsAMixtureDoes) {
  const testing::MovingPeaks target;
  Service service(table_options(), target);
  service.add_slice(testing::toy_slice(1, size));
  touch_all(service);
  const RowView row = service.peek(0, 0, 0);
  ASSERT_NE(row.knots, nullptr);
  EXPECT_EQ(row.density(0.4f), row.knots->density(0.4f));
  EXPECT_EQ(row.proposal_density(0.4f, 0.02f), row.knots->proposal_density(0.4f, 0.02f));
  EXPECT_EQ(row.sample(0.7f, 0.02f), row.knots->sample(0.7f, 0.02f));
  const RowView unknown;  // nothing published: uniform
  EXPECT_FLOAT_EQ(unknown.proposal_density(1, 0.02f), 0.5f * std::numbers::inv_pi_v<float>);
}

TEST(KnotRows, AreCountedByTheirKnotsAndNotAsMixtures) {
  const testing::MovingPeaks target;
  Service service(table_options(0.001), target);
  for (std::uint32_t lobe = 0; lobe < 3; ++lobe)
    service.add_slice(testing::toy_slice(lobe, size, 0.4f / (1 + 2 * lobe)));
  std::vector<RowReport> told;
  service.set_row_listener([&](const RowReport& report) { told.push_back(report); });
  const PassReport report = touch_all(service);
  EXPECT_EQ(report.rows_converged, 3 * nodes);
  EXPECT_EQ(report.knots[0] + report.knots[1] + report.knots[2], 3 * nodes);
  EXPECT_GT(report.knots[0], 0u);
  EXPECT_GT(report.knots[1] + report.knots[2], 0u);
  for (const std::uint64_t mixtures : report.components) EXPECT_EQ(mixtures, 0u);
  EXPECT_EQ(report.refits, 3 * nodes);
  ASSERT_EQ(told.size(), 3 * nodes);
  std::uint64_t g = 0, least = 0;
  for (const RowReport& row : told) {
    EXPECT_TRUE(KnotDensity::is_size(row.knots));
    EXPECT_EQ(row.components, 0u);
    EXPECT_EQ(row.count, 4 * row.knots);
    g += row.count;
    least += row.knots * sizeof(Knot);
  }
  EXPECT_EQ(report.g_evaluations, g);
  EXPECT_GE(report.bytes, least);
  EXPECT_LE(report.bytes, least * 2 + 3 * nodes * 512);  // nothing of what taught them is left
}

TEST(KnotRows, ThatTheKnotsCannotHoldAreAnsweredByG) {
  const testing::MovingPeaks target;
  SliceDescription slice = testing::toy_slice(1, size, 0.012f);  // knots are four blurs apart
  Service service(table_options(0.001), target);
  service.add_slice(slice);
  const PassReport report = touch_all(service);
  EXPECT_EQ(report.rows_refused, nodes);
  const RowView row = service.look_up(0, 0, 0);
  EXPECT_EQ(row.state, RowState::refused);
  EXPECT_EQ(row.knots, nullptr);
  EXPECT_EQ(row.fit, nullptr);
  ASSERT_NE(row.nodes, nullptr);
  EXPECT_GT(row.objective, 0.001f);
  EXPECT_EQ(touch_all(service).refits, 0u);  // for good

  const Result<TableSnapshot> saved = decode_cache(encode_cache(service.snapshot()), target.model_name(), "cache");
  ASSERT_TRUE(saved);
  for (const CachedRow& cached : saved->slices.at(0).rows) EXPECT_EQ(cached.state, RowState::open);
  Service again(table_options(0.001), target);
  again.add_slice(slice);
  ASSERT_FALSE(again.load(*saved));
  EXPECT_EQ(touch_all(again).rows_refused, nodes);
}

TEST(KnotRows, GoThroughTheCacheToTheBit) {
  const testing::MovingPeaks target;
  Service first(table_options(), target);
  first.add_slice(testing::toy_slice(1, size));
  touch_all(first);
  const std::string bytes = encode_cache(first.snapshot());
  for (const Learner* learner : {&knot_learner, &sketch_learner}) {  // whoever comes next reads them as they are
    Options options;
    options.learner = learner;
    Service second(options, target);
    second.add_slice(testing::toy_slice(1, size));
    Result<TableSnapshot> image = decode_cache(bytes, target.model_name(), "cache");
    ASSERT_TRUE(image);
    ASSERT_FALSE(second.load(std::move(*image)));
    const RowView row = second.peek(0, 2, 3);
    ASSERT_NE(row.knots, nullptr);
    EXPECT_EQ(row.state, RowState::converged);
    for (const float x : {-3.0f, 0.1f, 2.0f}) EXPECT_EQ(row.density(x), first.peek(0, 2, 3).density(x));
    EXPECT_EQ(encode_cache(second.snapshot()), bytes);
    const PassReport report = second.publish();
    EXPECT_EQ(report.rows_converged, nodes);
    EXPECT_EQ(report.knots[0] + report.knots[1] + report.knots[2], nodes);
    EXPECT_EQ(report.bytes, first.publish().bytes);
  }
}

// At a smaller epsilon some are open again: the table learner builds them anew, another learner learns mixtures; what
// the cache held is kept until the new row is there.
TEST(KnotRows, OfALargerEpsilonAreLearnedAnew) {
  const testing::MovingPeaks target;
  Service first(table_options(0.01), target);
  first.add_slice(testing::toy_slice(1, size, 0.1f));
  touch_all(first);
  const TableSnapshot image = first.snapshot();
  float largest = 0;
  for (const CachedRow& row : image.slices.at(0).rows) largest = std::max(largest, row.objective);
  for (const Learner* learner : {&knot_learner, &sketch_learner}) {
    Options options = table_options(largest / 2);
    options.learner = learner;
    Service second(options, target);
    second.add_slice(testing::toy_slice(1, size, 0.1f));
    ASSERT_FALSE(second.load(image));
    PassReport report;
    for (std::uint64_t pass = 0; pass < 30; ++pass) {
      testing::run_pass(second, 1, pass, 1000, 1);
      report = second.publish();
      ASSERT_EQ(second.snapshot().slices.at(0).rows.size(), nodes);
    }
    EXPECT_EQ(report.rows_converged, nodes) << learner->name;
    std::uint64_t mixtures = 0;
    for (const std::uint64_t count : report.components) mixtures += count;
    EXPECT_EQ(mixtures > 0, learner == &sketch_learner);
    const TableSnapshot learned = second.snapshot();
    for (const CachedRow& row : learned.slices.at(0).rows) EXPECT_LE(row.objective, options.epsilon);
  }
}

TEST(KnotRows, AreReopenedByAnAuditWhereTheTargetHasMoved) {
  class Shifted final : public Target {
   public:
    explicit Shifted(float shift) : shift_(shift) {}
    void trace(const SliceDescription&, float a, float b, std::vector<TracedRay>& out) const override {
      for (int i = 0; i < 64; ++i) out.push_back({a + shift_ + 0.01f * static_cast<float>(i), (1 + b) / 64, 1});
    }
    std::string model_name() const override { return "shifted"; }

   private:
    float shift_;
  };
  const Shifted before(0), after(0.5f);
  Service first(table_options(), before);
  first.add_slice(testing::toy_slice(1, size));
  touch_all(first);
  Service second(table_options(), after);
  second.add_slice(testing::toy_slice(1, size));
  ASSERT_FALSE(second.load(first.snapshot()));
  for (int pass = 0; pass < 3; ++pass) touch_all(second);
  for (std::uint32_t n = 0; n < nodes; ++n) {
    const RowView row = second.peek(0, n / size, n % size);
    ASSERT_NE(row.knots, nullptr);
    EXPECT_LE(true_objective(row, after, second.slice(0), n), 0.01) << n;
  }
  const TableSnapshot learned = second.snapshot();
  for (const CachedRow& row : learned.slices.at(0).rows) EXPECT_EQ(row.generation, 1u);
}

TEST(KnotRows, StayBelowTheCeilingInEveryPass) {
  const testing::MovingPeaks target;
  Options options = table_options(0.001);
  options.memory_bytes = 30000;
  Service service(options, target);
  for (std::uint32_t lobe = 0; lobe < 4; ++lobe) service.add_slice(testing::toy_slice(lobe, size, 0.1f));
  PassReport report;
  for (int pass = 0; pass < 6; ++pass) {
    report = touch_all(service);
    EXPECT_LE(report.bytes, options.memory_bytes);
  }
  EXPECT_TRUE(report.at_ceiling);
  EXPECT_GT(report.rows_converged, 0u);
  EXPECT_LT(report.rows_converged, 4 * nodes);
}

}  // namespace
}  // namespace tress::adaptive
