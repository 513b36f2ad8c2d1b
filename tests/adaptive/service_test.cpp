// The contract of a row's life: absent, open, converged, refused; and of the memory ceiling.
#include "tress/adaptive/service.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "adaptive/drive_service.h"
#include "adaptive/toy_target.h"
#include "tress/adaptive/cache.h"

namespace tress::inline v0_2::adaptive {
namespace {

using testing::MovingPeaks;
using testing::toy_slice;

TracedNodes trace_node(const Target& target, const SliceDescription& slice, std::uint32_t a, std::uint32_t b) {
  std::vector<TracedRay> rays;
  target.trace(slice, slice.axis_a[a], slice.axis_b[b], rays);
  return TracedNodes(rays, slice.blur_rad);
}

void touch(const Service& service, SliceId slice, std::uint32_t a, std::uint32_t b, int times) {
  for (int i = 0; i < times; ++i) service.look_up(slice, a, b);
}

TEST(Service, AnUnbornRowAnswersWithTheTargetAtItsNodeAndIsTracedOnceAPass) {
  const MovingPeaks target;
  Service service(Options{}, target);
  const SliceId slice = *service.add_slice(toy_slice(0, 4));
  const TracedNodes exact = trace_node(target, service.slice(slice), 1, 2);
  const RowView first = service.look_up(slice, 1, 2), second = service.look_up(slice, 1, 2);
  EXPECT_EQ(first.state, RowState::absent);
  EXPECT_EQ(first.row, RowView::no_row);
  EXPECT_EQ(first.fit, nullptr);
  EXPECT_EQ(first.nodes, second.nodes);
  for (int i = 0; i < 50; ++i) {
    EXPECT_EQ(first.nodes->density(0.13f * static_cast<float>(i)), exact.density(0.13f * static_cast<float>(i)));
  }
  const PassReport report = service.publish();
  EXPECT_EQ(report.queries, 2u);
  EXPECT_EQ(report.traces, 1u);
  EXPECT_EQ(report.rows_queried, 1u);
  EXPECT_EQ(report.creations, 0u);
}

TEST(Service, ATableThatDoesNotLearnAnswersAlikeForEverAndStaysAsItIs) {
  const MovingPeaks target;
  Options options;
  options.epsilon = 0.02;
  Service service(options, target);
  const SliceId slice = *service.add_slice(toy_slice(0, 4));
  service.add_slice(toy_slice(1, 4));  // not asked until the table is set not to learn
  for (std::uint64_t pass = 0; pass < 4; ++pass) {
    testing::run_pass(service, 1, pass, 3000, 1);
    service.publish();
  }
  const std::string before = cache_hash(service.snapshot());
  service.set_learning(false);
  std::size_t changed = 0;
  service.set_row_listener([&](const RowReport&) { ++changed; });
  for (std::uint64_t pass = 4; pass < 7; ++pass) {
    touch(service, slice, 0, 0, 100);
    testing::run_pass(service, 2, pass, 3000, 1);
    const PassReport report = service.publish();
    EXPECT_EQ(report.queries, 3100u);
    EXPECT_GT(report.converged_queries, 0u);
    EXPECT_EQ(report.creations + report.refits + report.g_evaluations + report.validation_draws, 0u);
    EXPECT_EQ(changed, 0u);
    EXPECT_EQ(cache_hash(service.snapshot()), before);
  }
  service.set_learning(true);
  testing::run_pass(service, 2, 7, 3000, 1);
  EXPECT_GT(service.publish().g_evaluations, 0u);
  EXPECT_NE(cache_hash(service.snapshot()), before);
}

TEST(Service, TouchesAreCarriedFromPassToPassUntilARowIsBornCoveredAndFitted) {
  const MovingPeaks target;
  Service service(Options{}, target);
  const SliceId slice = *service.add_slice(toy_slice(0, 4));
  std::vector<RowReport> changes;
  service.set_row_listener([&](const RowReport& row) { changes.push_back(row); });
  touch(service, slice, 3, 1, 7);
  EXPECT_EQ(service.publish().creations, 0u);
  EXPECT_TRUE(changes.empty());
  touch(service, slice, 3, 1, 1);
  const PassReport report = service.publish();
  EXPECT_EQ(report.creations, 1u);
  EXPECT_EQ(report.refits, 1u);
  EXPECT_EQ(report.g_evaluations, 13u);  // ceil(2 pi/(2.5 * 0.2))
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_EQ(changes[0].node, 13u);
  EXPECT_EQ(changes[0].state, RowState::open);
  const RowView row = service.peek(slice, 3, 1);
  EXPECT_EQ(row.state, RowState::open);
  ASSERT_NE(row.fit, nullptr);
  ASSERT_NE(row.nodes, nullptr);
  EXPECT_NEAR(row.fit->energy(), row.nodes->energy(), 1e-4);
}

TEST(Service, PeekingCountsNoQueryAndTheTableStaysWhileAPassRuns) {
  const MovingPeaks target;
  Service service(Options{}, target);
  const SliceId slice = *service.add_slice(toy_slice(0, 2));
  for (int i = 0; i < 20; ++i) EXPECT_EQ(service.peek(slice, 0, 0).state, RowState::absent);
  touch(service, slice, 0, 0, 100);
  EXPECT_EQ(service.peek(slice, 0, 0).state, RowState::absent) << "no birth before publish()";
  EXPECT_EQ(service.publish().queries, 100u);
  const Mixture before = *service.peek(slice, 0, 0).fit;
  for (std::uint64_t i = 0; i < 200; ++i) testing::ask(service, 1, 0, i);
  EXPECT_EQ(service.peek(slice, 0, 0).fit->density(0.3f), before.density(0.3f));
}

TEST(Service, AConvergedRowDropsItsNodesAndEvaluatesNothing) {
  const MovingPeaks target;
  Service service(Options{}, target);
  const SliceId slice = *service.add_slice(toy_slice(0, 2));
  PassReport report;
  for (std::uint64_t pass = 0; pass < 20 && report.rows_converged < 4; ++pass) {
    testing::run_pass(service, 1, pass, 200, 1);
    report = service.publish();
  }
  ASSERT_EQ(report.rows_converged, 4u);
  const RowView row = service.look_up(slice, 0, 1);
  EXPECT_EQ(row.nodes, nullptr);
  ASSERT_NE(row.fit, nullptr);
  service.observe(row, 0.1f, 99.0f);
  service.score(row, 0.1f, 99.0f, 0.1f);
  std::size_t changed = 0;
  service.set_row_listener([&](const RowReport&) { ++changed; });
  report = service.publish();
  EXPECT_EQ(report.g_evaluations, 0u);
  EXPECT_EQ(report.queries, report.converged_queries);
  EXPECT_EQ(changed, 0u);
  // Attributes: every ray has 1 or 3, so every mean lies between.
  const Mixture fit = *row.fit;
  for (const Component& part : fit.parts()) {
    EXPECT_GE(part.attribute_mean, 1 - 1e-4f);
    EXPECT_LE(part.attribute_mean, 3 + 1e-4f);
  }
}

TEST(Service, AViewHasTheBoundOfTheLastTest) {
  const MovingPeaks target;
  Service service(Options{}, target);
  const SliceId slice = *service.add_slice(toy_slice(0, 2));
  EXPECT_EQ(service.look_up(slice, 1, 1).objective, 1.0f) << "unborn";
  touch(service, slice, 1, 1, 8);
  service.publish();
  EXPECT_EQ(service.look_up(slice, 1, 1).objective, 1.0f) << "born and not tested";
  float reported = 1;
  service.set_row_listener([&](const RowReport& row) {
    if (row.objective >= 0 && row.node == 3) reported = static_cast<float>(row.objective);
  });
  bool converged = false;
  for (std::uint64_t pass = 0; pass < 20 && !converged; ++pass) {
    testing::run_pass(service, 1, pass, 200, 1);
    service.publish();
    converged = service.peek(slice, 1, 1).state == RowState::converged;
  }
  ASSERT_TRUE(converged);
  const RowView row = service.look_up(slice, 1, 1);
  EXPECT_EQ(row.objective, reported);
  EXPECT_LE(row.objective, service.options().epsilon);
  EXPECT_EQ(row.objective, service.snapshot().slices[0].rows.back().objective);
}

TEST(Service, PastTheCeilingNoRowIsBornAndAnswersStayExact) {
  const MovingPeaks target;
  Options options;
  options.memory_bytes = 12000;
  Service service(options, target);
  const SliceId slice = *service.add_slice(toy_slice(0, 6));
  const SliceDescription& description = service.slice(slice);
  bool was_at_ceiling = false;
  for (int pass = 0; pass < 3; ++pass) {
    for (std::uint32_t node = 0; node < 36; ++node) {
      for (int i = 0; i < 9; ++i) {
        const RowView row = service.look_up(slice, node / 6, node % 6);
        ASSERT_NE(row.nodes, nullptr);
        const float x = 0.7f * static_cast<float>(i);
        if (i == 0) {
          EXPECT_EQ(row.nodes->density(x), trace_node(target, description, node / 6, node % 6).density(x));
        }
      }
    }
    const PassReport report = service.publish();
    EXPECT_LE(report.bytes, options.memory_bytes);
    was_at_ceiling = was_at_ceiling || report.at_ceiling;
    EXPECT_GT(report.rows_open + report.rows_converged, 0u);
  }
  EXPECT_TRUE(was_at_ceiling);
}

TEST(Service, NoMemoryAtAllIsStillAnsweredExactly) {
  const MovingPeaks target;
  Options options;
  options.memory_bytes = 0;
  Service service(options, target);
  const SliceId slice = *service.add_slice(toy_slice(0, 2));
  touch(service, slice, 1, 1, 50);
  const PassReport report = service.publish();
  EXPECT_EQ(report.creations, 0u);
  EXPECT_EQ(report.bytes, 0u);
  EXPECT_TRUE(report.at_ceiling);
  const RowView row = service.look_up(slice, 1, 1);
  ASSERT_NE(row.nodes, nullptr);
  EXPECT_EQ(row.nodes, row.kept.get());
  EXPECT_EQ(row.nodes->density(1.0f), trace_node(target, service.slice(slice), 1, 1).density(1.0f));
}

TEST(Service, ARowThatFailsItsTestsIsRefusedAnsweredExactlyAndSavedAsOpen) {
  const MovingPeaks target;  // two skewed peaks: one component cannot come near 1e-6
  Options options;
  options.epsilon = 1e-6;
  options.max_components = 1;
  options.tests_before_refusal = 5;
  Service service(options, target);
  const SliceId slice = *service.add_slice(toy_slice(0, 1));
  std::multiset<RowState> reported;
  service.set_row_listener([&](const RowReport& row) { reported.insert(row.state); });
  PassReport report;
  for (std::uint64_t pass = 0; pass < 6; ++pass) {
    testing::run_pass(service, 1, pass, 100, 1);
    report = service.publish();
  }
  EXPECT_EQ(report.rows_refused, 1u);
  EXPECT_EQ(reported.count(RowState::refused), 1u);
  const RowView row = service.look_up(slice, 0, 0);
  EXPECT_EQ(row.state, RowState::refused);
  ASSERT_NE(row.nodes, nullptr);
  EXPECT_EQ(row.nodes->density(0.4f), trace_node(target, service.slice(slice), 0, 0).density(0.4f));
  testing::run_pass(service, 1, 7, 100, 1);
  report = service.publish();
  EXPECT_EQ(report.refits, 0u);
  EXPECT_EQ(report.g_evaluations, 0u);
  const TableSnapshot image = service.snapshot();
  ASSERT_EQ(image.slices.size(), 1u);
  EXPECT_EQ(image.slices[0].rows[0].state, RowState::open);
  EXPECT_FALSE(image.slices[0].rows[0].density()->sketch.empty());
}

TEST(Service, BirthsGoByCountThenByKeyThenByNode) {
  const MovingPeaks target;
  Service all(Options{}, target);
  const SliceId one = *all.add_slice(toy_slice(0, 2));
  touch(all, one, 0, 0, 8);
  const std::size_t row_bytes = all.publish().bytes;

  Options options;
  options.memory_bytes = 2 * row_bytes + row_bytes / 2;  // two open rows, nodes of all rows are as many
  Service service(options, target);
  const SliceId late = *service.add_slice(toy_slice(1, 2)), early = *service.add_slice(toy_slice(0, 2));
  touch(service, late, 0, 0, 9);
  touch(service, late, 1, 1, 8);
  touch(service, early, 1, 1, 8);
  EXPECT_EQ(service.publish().creations, 2u);
  EXPECT_EQ(service.peek(late, 0, 0).state, RowState::open);   // asked most
  EXPECT_EQ(service.peek(early, 1, 1).state, RowState::open);  // smaller key, though added later
  EXPECT_EQ(service.peek(late, 1, 1).state, RowState::absent);
}

TEST(Service, TopUpTestsARowThatIsHardlyEverScored) {
  const MovingPeaks target;
  Service service(Options{}, target);
  const SliceId slice = *service.add_slice(toy_slice(0, 1));
  PassReport report;
  std::uint64_t validation_draws = 0;
  for (int pass = 0; pass < 20 && report.rows_converged == 0; ++pass) {
    touch(service, slice, 0, 0, 8);  // never observed
    report = service.publish();
    validation_draws += report.validation_draws;
    if (pass == 0) {
      EXPECT_EQ(report.validation_draws, 0u) << "the pass of the birth draws nothing of its own";
    }
  }
  EXPECT_EQ(report.rows_converged, 1u);
  EXPECT_EQ(validation_draws % service.options().scores_per_test(), 0u);
  EXPECT_GE(validation_draws, 2u * service.options().scores_per_test());
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
