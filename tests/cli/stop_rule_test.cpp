// When a render ends, and what it says is left.
#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <string>

#include "cli/progress.h"

namespace tress::cli {
namespace {

/// After pass `pass` of 103 (100 samples) over 6400 pixels, each full pass of 2 s.
integrate::PassProgress after(int pass, double noise = 0) {
  integrate::PassProgress progress;
  progress.pass = pass;
  progress.pass_count = 103;
  progress.paths_total = 640000;
  const std::uint64_t first[] = {100, 400, 1600, 4300};
  progress.pixels = pass < 4 ? first[pass] : 6400;
  for (int i = 0; i <= pass; ++i) progress.paths_so_far += i < 4 ? first[i] : 6400;
  progress.seconds = 2.0 * double(progress.pixels) / 6400;
  progress.noise = noise;
  return progress;
}

std::string reason(const Outlook& outlook) { return outlook.reason == nullptr ? "" : outlook.reason; }

TEST(StopRule, samples_end_with_the_last_pass) {
  EXPECT_EQ(reason(outlook({}, after(50), 90, 90)), "");
  const Outlook half = outlook({}, after(52), 120, 100);
  EXPECT_DOUBLE_EQ(half.share, 0.5);
  EXPECT_DOUBLE_EQ(half.seconds_left, 100);
  EXPECT_EQ(reason(outlook({}, after(102), 200, 200)), "samples");
  EXPECT_EQ(StopRule{}.samples(7), 7);
}

TEST(StopRule, time_ends_where_the_next_pass_would_be_too_late) {
  const StopRule rule{30.0, std::nullopt};
  EXPECT_EQ(reason(outlook(rule, after(10), 27.9, 20)), "");
  EXPECT_EQ(reason(outlook(rule, after(10), 28.1, 20)), "time");
  EXPECT_EQ(reason(outlook(rule, after(2), 100, 20)), "") << "sample 0 is finished whatever it takes";
  // The last part of sample 0 took 1.34 s, a whole pass takes 2.
  EXPECT_EQ(reason(outlook(rule, after(3), 28.1, 20)), "time");
  EXPECT_EQ(reason(outlook(rule, after(3), 27.9, 20)), "");
  const Outlook ahead = outlook(rule, after(10), 12, 10);
  EXPECT_DOUBLE_EQ(ahead.share, 0.4);
  EXPECT_DOUBLE_EQ(ahead.seconds_left, 18);
  EXPECT_EQ(rule.samples(7), StopRule::most_samples);
}

TEST(StopRule, noise_ends_when_reached_or_after_the_most_samples) {
  const StopRule rule{std::nullopt, 0.01};
  EXPECT_EQ(reason(outlook(rule, after(10, 0.011), 20, 20)), "");
  EXPECT_EQ(reason(outlook(rule, after(10, 0.01), 20, 20)), "noise");
  EXPECT_EQ(reason(outlook(rule, after(5, 0.001), 20, 20)), "") << "3 samples tell little of a variance";
  EXPECT_EQ(reason(outlook(rule, after(6, 0.001), 20, 20)), "noise");
  EXPECT_EQ(reason(outlook(rule, after(102, 1), 20, 20)), "samples");
  // Twice the noise asked for: four times the samples, three quarters left.
  const Outlook ahead = outlook(rule, after(10, 0.02), 24, 20);
  EXPECT_NEAR(ahead.share, 0.25, 1e-12);
  EXPECT_NEAR(ahead.seconds_left, 60, 1e-9);
}

}  // namespace
}  // namespace tress::cli
