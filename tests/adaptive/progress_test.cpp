// Options::progress: what is passed to it, what it changes, and that work which it ends is done later.
#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "adaptive/toy_samples.h"
#include "adaptive/toy_target.h"
#include "tress/adaptive/cache.h"
#include "tress/adaptive/service.h"

namespace tress::inline v0_2::adaptive {
namespace {

const testing::MovingPeaks peaks;
const testing::MovingLobes lobes;

/// A service with a slice of either kind; the one of samples has a coarser grid.
struct Learner {
  explicit Learner(std::function<bool(double)> progress)
      : service(
            [&] {
              Options options;
              options.progress = std::move(progress);
              return options;
            }(),
            peaks, lobes) {
    densities = *service.add_slice(testing::toy_slice(0, 3));
    SliceDescription coarse = testing::sampled_slice(1, 3);
    coarse.coarse = {{{0, 2}, {0, 2}}};
    samples = *service.add_slice(coarse);
  }
  PassReport pass() {
    for (std::uint32_t node = 0; node < 9; ++node) {
      for (int i = 0; i < 100; ++i) {
        const RowView row = service.look_up(densities, node / 3, node % 3);
        const float x = row.sample((static_cast<float>(i) + 0.5f) / 100, 0.05f);
        if (row.nodes != nullptr) service.score(row, x, row.nodes->density(x), row.proposal_density(x, 0.05f));
        service.credit(service.look_up(samples, node / 3, node % 3), 1);
      }
    }
    return service.publish(900);
  }
  Service service;
  SliceId densities = 0, samples = 0;
};

TEST(Progress, RisesAndChangesNothing) {
  std::vector<double> seen;
  Learner asked([&](double done) {
    seen.push_back(done);
    return true;
  });
  Learner unasked(nullptr);
  for (int pass = 0; pass < 8; ++pass) {
    seen.clear();
    EXPECT_FALSE(asked.pass().cancelled);
    unasked.pass();
    EXPECT_GE(seen.size(), 3u);
    for (std::size_t i = 0; i < seen.size(); ++i)
      EXPECT_TRUE(seen[i] >= (i == 0 ? 0 : seen[i - 1]) && seen[i] < 1) << i << ": " << seen[i];
  }
  EXPECT_EQ(cache_hash(asked.service.snapshot()), cache_hash(unasked.service.snapshot()));
}

// Ended at every possible place in turn: no row is half made, and all are learned once nobody ends the work.
TEST(Progress, WorkThatItEndsIsDoneLater) {
  int left = 0;
  Learner stopped([&](double) { return left-- > 0; });
  bool has_ended = false;
  for (int most = 0; most < 8; ++most) {
    left = most;
    has_ended = stopped.pass().cancelled;
    EXPECT_EQ(has_ended, left < 0) << most;
    for (const CachedSlice& slice : stopped.service.snapshot().slices)
      for (const CachedRow& row : slice.rows)
        EXPECT_TRUE(row.state != RowState::converged || row.ribbons() != nullptr || row.energy > 0) << most;
  }
  EXPECT_FALSE(has_ended) << "there are fewer places";
  PassReport report;
  left = 1 << 20;
  for (int pass = 0; pass < 8; ++pass) report = stopped.pass();
  EXPECT_EQ(report.rows_converged + report.rows_open, 18u);
  EXPECT_GE(report.rows_converged, 9u);
}

TEST(Progress, OneThatThrowsIsReportedAndEndsNothing) {
  Learner learner([](double) -> bool { throw std::runtime_error("no screen"); });
  const PassReport report = learner.pass();
  ASSERT_TRUE(report.misuse.has_value());
  EXPECT_EQ(report.misuse->message(), "progress: expected no exception, found no screen");
  EXPECT_FALSE(report.cancelled);
  EXPECT_GT(report.rows_open, 0u);
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
