// Targets that throw or give what they must not, and descriptions that make no slice: the service goes on, says so, and
// what it knows can be saved.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "adaptive/toy_target.h"
#include "tress/adaptive/cache.h"
#include "tress/adaptive/service.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();

Options eager(bool checks) {
  Options options;
  options.queries_before_creation = 1;
  options.check_passes = checks;
  return options;
}

/// Throws at a node while `throws`, and gives `wrong` as the weight of one of its rays while that is not 0.
class Faulty final : public Target {
 public:
  void trace(const SliceDescription& slice, float a, float b, std::vector<TracedRay>& out) const override {
    peaks_.trace(slice, a, b, out);
    if (a != slice.axis_a[1] || b != slice.axis_b[1]) return;
    if (throws) throw std::runtime_error("no rays today");
    if (wrong != 0) out[3].weight = wrong;
  }
  std::string model_name() const override { return "faulty-1"; }
  bool throws = false;
  float wrong = 0;

 private:
  testing::MovingPeaks peaks_;
};

void ask(const Service& service, SliceId slice, int nodes) {
  for (int a = 0; a < nodes; ++a) {
    for (int b = 0; b < nodes; ++b) {
      for (int i = 0; i < 64; ++i) {
        const RowView row = service.look_up(slice, static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b));
        const float u = (static_cast<float>(i) + 0.5f) / 64, x = row.sample(u, 0.5f);
        if (row.nodes != nullptr) service.score(row, x, row.nodes->density(x), row.proposal_density(x, 0.5f));
      }
    }
  }
}

class HostFaults : public ::testing::TestWithParam<bool> {};

// It counted as converged, and snapshot() ended the host; where passes are checked the service was dead for good.
TEST_P(HostFaults, ATargetThatThrowsOnceIsReportedAndLearnedLater) {
  Faulty target;
  Service service(eager(GetParam()), target);
  const SliceId slice = *service.add_slice(testing::toy_slice(0, 3));
  target.throws = true;
  for (int pass = 0; pass < 3; ++pass) {
    ask(service, slice, 3);
    const PassReport report = service.publish();
    ASSERT_TRUE(report.misuse.has_value());
    EXPECT_EQ(report.misuse->message(), "Target::trace: expected no exception, found no rays today");
    EXPECT_EQ(report.rows_converged + report.rows_open, 8u);
    EXPECT_EQ(service.peek(slice, 1, 1).state, RowState::absent);
    EXPECT_EQ(service.snapshot().slices.size(), 1u);
  }
  target.throws = false;
  ask(service, slice, 3);
  const PassReport report = service.publish();
  EXPECT_FALSE(report.misuse.has_value());
  EXPECT_EQ(report.rows_converged + report.rows_open, 9u);
}

// A weight without end converged, and the whole cache could not be saved.
TEST_P(HostFaults, InvalidRaysAreReportedAndNotLearned) {
  for (const float wrong : {infinity, nan, -1.0f}) {
    Faulty target;
    target.wrong = wrong;
    Service service(eager(GetParam()), target);
    const SliceId slice = *service.add_slice(testing::toy_slice(0, 3));
    EXPECT_EQ(service.look_up(slice, 1, 1).nodes->density(0.5f), 0) << "and nothing is answered";
    for (int pass = 0; pass < 4; ++pass) {
      ask(service, slice, 3);
      const PassReport report = service.publish();
      ASSERT_TRUE(report.misuse.has_value());
      EXPECT_EQ(report.misuse->place, "Target::trace");
    }
    EXPECT_EQ(service.peek(slice, 1, 1).state, RowState::absent);
    const std::string file = ::testing::TempDir() + "/host_faults.cache";
    EXPECT_TRUE(merge_into_cache(file, *service.rows()));
    EXPECT_TRUE(load_cache(file, "faulty-1"));
    std::remove(file.c_str());
  }
}

class ThrowingSamples final : public SampledTarget {
 public:
  std::uint32_t parts(const SliceDescription&) const override { return 1; }
  void draw(const SliceDescription&, float, float, std::uint64_t, std::uint32_t, std::uint32_t,
            std::vector<SampledExit>&) const override {
    throw 3;
  }
  std::string model_name() const override { return "throwing-1"; }
};

TEST_P(HostFaults, ATargetOfSamplesThatThrowsIsRefused) {
  const ThrowingSamples target;
  Service service(eager(GetParam()), target);
  SliceDescription description = testing::toy_slice(0, 3);
  description.kind = SliceKind::samples;
  const SliceId slice = *service.add_slice(description);
  ask(service, slice, 3);
  const PassReport report = service.publish();
  ASSERT_TRUE(report.misuse.has_value());
  EXPECT_EQ(report.misuse->found, "one that is no std::exception");
  EXPECT_EQ(report.rows_refused, 9u);
  EXPECT_EQ(service.snapshot().slices.size(), 1u);
}

TEST_P(HostFaults, SlicesThatAreNoneAreRefused) {
  const testing::MovingPeaks target;
  Service service(eager(GetParam()), target);
  const SliceDescription right = testing::toy_slice(0, 3);
  std::vector<SliceDescription> wrong(8, right);
  wrong[0].axis_a = {1, 0};
  wrong[1].axis_b = {0, nan, 1};
  wrong[2].blur_rad = 0;
  wrong[3].blur_rad = nan;
  wrong[4].axis_a = {0, 0};
  wrong[5].key.parameters[1] = infinity;
  wrong[6].axis_b = {};
  wrong[7].blur_rad = -1;
  for (std::size_t i = 0; i < wrong.size(); ++i) EXPECT_FALSE(service.add_slice(wrong[i])) << i;
  EXPECT_EQ(service.slice_count(), 0u);
  EXPECT_TRUE(service.add_slice(right));
}

TEST_P(HostFaults, NodesViewsAndSlicesThatAreNotThereAreAnswered) {
  const testing::MovingPeaks target;
  Service service(eager(GetParam()), target);
  const SliceId slice = *service.add_slice(testing::toy_slice(0, 3));
  EXPECT_EQ(service.look_up(slice, 0, 99).nodes->density(1), 0);
  const PassReport report = service.publish();
  ASSERT_TRUE(report.misuse.has_value());
  EXPECT_EQ(report.misuse->found, "a 0, b 99 of slice 0");
  EXPECT_EQ(service.slice(7).node_count(), 0u);
  EXPECT_EQ(service.peek(slice, 0, 7).state, RowState::absent);
  EXPECT_FALSE(service.add_form(slice, nullptr));
  ask(service, slice, 3);
  service.publish();
  const RowView row = service.look_up(slice, 1, 1);
  Service other(eager(GetParam()), target);  // a view of one, passed to another
  other.observe(row, 0.5f, 1);
  other.score(row, 0.5f, 1, 1);
  other.credit(row, 1);
  service.observe(row, nan, nan);
  service.score(row, nan, infinity, -1);
  service.credit(row, nan);
  service.credit(row, infinity, ~0u);
  service.publish();
  service.set_row_listener([](const RowReport&) { throw std::runtime_error("listener"); });
  ask(service, slice, 3);
  service.publish();
  service.set_row_listener(nullptr);
  service.publish();
}

INSTANTIATE_TEST_SUITE_P(Checked, HostFaults, ::testing::Bool());

}  // namespace
}  // namespace tress::inline v0_2::adaptive
