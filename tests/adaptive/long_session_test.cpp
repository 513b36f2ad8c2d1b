// A table that is asked for longer than it can learn, and one that many short sessions take over from each other.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "adaptive/drive_service.h"
#include "adaptive/toy_target.h"
#include "tress/adaptive/cache.h"
#include "tress/adaptive/service.h"

namespace tress::inline v0_2::adaptive {
namespace {

TEST(LongSession, AtEpsilonOneMillionthLearningEndsAndMemoryStandsStill) {
  const testing::MovingPeaks target;
  Options options;
  options.epsilon = 1e-6;  // two bundles with a caustic's shape: eight components do not always reach it
  Service service(options, target);
  service.add_slice(testing::toy_slice(0, 6));
  constexpr std::uint64_t passes = 120;
  std::vector<PassReport> reports;
  for (std::uint64_t pass = 0; pass < passes; ++pass) {
    testing::run_pass(service, 1, pass, 3000, 1);
    reports.push_back(service.publish());
    ASSERT_LE(reports.back().bytes, options.memory_bytes);
    ASSERT_EQ(reports.back().rows_open + reports.back().rows_converged + reports.back().rows_refused, 36u);
  }
  // Every row has had its last test: 32 that fail, or three in turn that pass between failures.
  const PassReport& last = reports.back();
  EXPECT_EQ(last.rows_open, 0u);
  EXPECT_EQ(last.rows_reopened, 0u);
  std::uint64_t refits = 0;
  for (const PassReport& report : reports) refits += report.refits;
  EXPECT_LE(refits, 36u * options.tests_before_refusal * options.tests_to_converge());
  for (std::size_t pass = reports.size() - 10; pass < reports.size(); ++pass) {
    EXPECT_EQ(reports[pass].refits, 0u);
    EXPECT_EQ(reports[pass].g_evaluations, 0u) << "no row is learned any more, and refused ones are traced by readers";
    EXPECT_EQ(reports[pass].bytes, last.bytes);
    EXPECT_EQ(reports[pass].traces, 0u);
  }
}

/// Twelve sessions on one table, each with other queries, of changing slices.
std::vector<std::string> sessions(unsigned threads) {
  const tbb::global_control width(tbb::global_control::max_allowed_parallelism, threads);
  const testing::MovingPeaks target;
  TableSnapshot table{target.model_name(), {}};
  std::vector<std::string> saved;
  for (std::uint64_t session = 0; session < 12; ++session) {
    Options options;
    options.seed = session;
    Service service(options, target);
    for (std::uint32_t p = 0; p < 2; ++p) {
      service.add_slice(testing::toy_slice(static_cast<std::uint32_t>(session + p) % 4, 8));
    }
    EXPECT_FALSE(service.load(table).has_value());
    for (std::uint64_t pass = 0; pass < 4; ++pass) {
      testing::run_pass(service, 2, 100 * session + pass, 1500, threads);
      service.publish();
    }
    table = merge_caches(table, service.snapshot());
    saved.push_back(encode_cache(table));
  }
  return saved;
}

TEST(LongSession, TwelveSessionsOnOneTableAreTheSameWhateverTheThreads) {
  const std::vector<std::string> one = sessions(1);
  const auto still = std::ranges::count(one, one.back());
  EXPECT_GE(still, 2) << "once all has converged, a session leaves the file as it was";
  EXPECT_LE(still, 9) << "the first sessions must have learned";
  for (const unsigned threads : {2u, 8u}) EXPECT_EQ(sessions(threads), one);
}

TEST(LongSession, TheFileOfTwelveSessionsShrinksAsRowsConverge) {
  std::vector<std::size_t> sizes;
  for (const std::string& bytes : sessions(1)) sizes.push_back(bytes.size());
  const auto largest = std::ranges::max_element(sizes) - sizes.begin();
  EXPECT_LT(largest, 8) << "a row that converges leaves its sketch";
  EXPECT_LT(sizes.back(), sizes[static_cast<std::size_t>(largest)]);
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
