// Options::memory_monitor: its sums are PassReport::bytes, and a service grows no further where it refuses.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "adaptive/toy_samples.h"
#include "adaptive/toy_target.h"
#include "tress/adaptive/query.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::adaptive {
namespace {

const testing::MovingPeaks peaks;
const testing::MovingLobes lobes;

/// What a monitor has seen.
struct Seen {
  std::int64_t sum = 0;
  int asked = 0, reported = 0, most = 1000000;  ///< most: of rows, before it refuses
  bool throws = false;
  bool note(std::int64_t bytes, bool post) {
    if (throws) throw std::runtime_error("a monitor");
    EXPECT_NE(bytes, 0);
    EXPECT_TRUE(post || bytes > 0);
    ++(post ? reported : asked);
    const bool takes = post || asked <= most;
    if (takes) sum += bytes;
    return takes;
  }
};

/// A service with a slice of either kind, and a form that copies the row's energy.
struct Watched {
  explicit Watched(Seen* seen, std::size_t memory = std::size_t{64} << 20)
      : service(std::make_unique<Service>(options(seen, memory), peaks, lobes)) {
    densities = *service->add_slice(testing::toy_slice(0, 3));
    SliceDescription coarse = testing::sampled_slice(1, 3);
    coarse.coarse = {{{0, 2}, {0, 2}}};
    samples = *service->add_slice(coarse);
    rows = *service->add_form(densities, std::make_shared<Block>());
  }
  struct Block final : RowForm {
    std::size_t bytes(const RowView&) const override { return 256; }
    void write(const RowView& row, void* memory) const override { *static_cast<float*>(memory) = row.fit->energy(); }
  };
  static Options options(Seen* seen, std::size_t memory) {
    Options options;
    options.memory_bytes = memory;
    if (seen != nullptr)
      options.memory_monitor = [seen](std::int64_t bytes, bool post) { return seen->note(bytes, post); };
    return options;
  }
  PassReport pass(std::uint64_t number) {
    for (std::uint32_t node = 0; node < 9; ++node) {
      RandomStream random(3, number, node);
      for (int i = 0; i < 100; ++i) {
        sample(*service, {densities, node / 3, node % 3}, {random.next(), 0, 0});
        sample(*service, {samples, node / 3, node % 3}, {random.next(), random.next(), random.next()});
      }
      (void)service->look_up(*rows, node);
    }
    return service->publish();
  }
  std::unique_ptr<Service> service;
  SliceId densities = 0, samples = 0;
  const FormedRows* rows = nullptr;
};

TEST(MemoryMonitor, SumsToTheReportAtEveryPublishAndToZeroAtTheEnd) {
  Seen seen;
  Watched watched(&seen), alone(nullptr);
  EXPECT_GT(seen.sum, 0) << "the entries of the form";
  watched.service->prepare();
  alone.service->prepare();
  for (std::uint64_t pass = 0; pass < 10; ++pass) {
    const PassReport report = watched.pass(pass);
    alone.pass(pass);
    EXPECT_EQ(seen.sum, static_cast<std::int64_t>(report.bytes)) << pass;
  }
  EXPECT_EQ(seen.asked, 18) << "a question for each row";
  EXPECT_EQ(cache_hash(watched.service->snapshot()), cache_hash(alone.service->snapshot()));

  const Result<std::string> state = watched.service->state();
  ASSERT_TRUE(state.has_value());
  Seen of_restored, of_loaded;
  Watched restored(&of_restored), loaded(&of_loaded);
  EXPECT_FALSE(restored.service->restore(*state));
  EXPECT_FALSE(loaded.service->load(watched.service->snapshot()));
  EXPECT_GT(of_loaded.asked, 0);
  for (const auto& [one, sums] : {std::pair{&restored, &of_restored}, {&loaded, &of_loaded}, {&watched, &seen}}) {
    EXPECT_EQ(sums->sum, static_cast<std::int64_t>(one->pass(10).bytes));
    one->service.reset();
    EXPECT_EQ(sums->sum, 0);
  }
}

// Of either kind, in the order of their pass; nodes without a row are answered by their target, and get it later.
TEST(MemoryMonitor, ThatRefusesHoldsRowsBackUntilItAgrees) {
  Seen seen;
  seen.most = 4;
  Watched watched(&seen);
  std::uint64_t pass = 0;
  for (; pass < 6; ++pass) {
    const PassReport report = watched.pass(pass);
    EXPECT_TRUE(report.at_ceiling);
    EXPECT_EQ(report.rows_open + report.rows_converged + report.rows_refused, 4u);
    EXPECT_EQ(seen.asked, 5 + static_cast<int>(pass)) << "once a call, after it has refused";
    EXPECT_EQ(seen.sum, static_cast<std::int64_t>(report.bytes));
    for (std::uint32_t node = 0; node < 9; ++node)
      EXPECT_TRUE(evaluate(*watched.service, {watched.densities, node / 3, node % 3}, 1).answered);
  }
  seen.most = 1000000;
  const PassReport report = watched.pass(pass);
  EXPECT_FALSE(report.at_ceiling);
  EXPECT_EQ(report.rows_open + report.rows_converged + report.rows_refused, 18u);
  watched.service.reset();
  EXPECT_EQ(seen.sum, 0);
}

TEST(MemoryMonitor, ThatThrowsIsReportedAndChangesNothing) {
  Seen seen;
  Watched watched(&seen), alone(nullptr);
  seen.throws = true;
  const PassReport report = watched.pass(0);
  ASSERT_TRUE(report.misuse);
  EXPECT_EQ(report.misuse->place, "memory_monitor");
  alone.pass(0);
  EXPECT_EQ(cache_hash(watched.service->snapshot()), cache_hash(alone.service->snapshot()));
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
