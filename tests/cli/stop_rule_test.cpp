// When a render ends, and what it says is left.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

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
  progress.light_paths = 1000;
  return progress;
}

std::string reason(const Outlook& outlook) { return outlook.reason == nullptr ? "" : outlook.reason; }

/// The outlook after this pass, once all passes before it were passed in.
Outlook outlook(const StopRule& rule, const integrate::PassProgress& pass, double elapsed) {
  Forecast forecast(rule);
  for (int earlier = 0; earlier < pass.pass; ++earlier) forecast.after(after(earlier, pass.noise), 0);
  return forecast.after(pass, elapsed);
}

TEST(StopRule, samples_end_with_the_last_pass) {
  EXPECT_EQ(reason(outlook({}, after(50), 90)), "");
  const Outlook half = outlook({}, after(52), 120);
  EXPECT_DOUBLE_EQ(half.share, 0.5);
  EXPECT_NEAR(half.seconds_left.value(), 100, 1e-9);
  EXPECT_EQ(reason(outlook({}, after(102), 200)), "samples");
  EXPECT_EQ(StopRule{}.samples(7), 7);
}

TEST(StopRule, time_ends_where_the_next_pass_would_be_too_late) {
  const StopRule rule{30.0, std::nullopt};
  EXPECT_EQ(reason(outlook(rule, after(10), 27.9)), "");
  EXPECT_EQ(reason(outlook(rule, after(10), 28.1)), "time");
  EXPECT_EQ(reason(outlook(rule, after(2), 100)), "") << "sample 0 is finished whatever it takes";
  // The last part of sample 0 took 1.34 s, a whole pass takes 2.
  EXPECT_EQ(reason(outlook(rule, after(3), 28.1)), "time");
  EXPECT_EQ(reason(outlook(rule, after(3), 27.9)), "");
  const Outlook ahead = outlook(rule, after(10), 12);
  EXPECT_DOUBLE_EQ(ahead.share, 0.4);
  EXPECT_DOUBLE_EQ(ahead.seconds_left.value(), 18);
  EXPECT_EQ(rule.samples(7), StopRule::most_samples);
}

TEST(StopRule, noise_ends_when_reached_or_after_the_most_samples) {
  const StopRule rule{std::nullopt, 0.01};
  EXPECT_EQ(reason(outlook(rule, after(10, 0.011), 20)), "");
  EXPECT_EQ(reason(outlook(rule, after(10, 0.01), 20)), "noise");
  EXPECT_EQ(reason(outlook(rule, after(5, 0.001), 20)), "") << "3 samples say little of a variance";
  EXPECT_EQ(reason(outlook(rule, after(6, 0.001), 20)), "noise");
  EXPECT_EQ(reason(outlook(rule, after(102, 1), 20)), "samples");
  // Twice the noise asked for: four times the samples, three quarters left of 8 samples of 2 s each.
  const Outlook ahead = outlook(rule, after(10, 0.02), 24);
  EXPECT_NEAR(ahead.share, 0.25, 1e-12);
  EXPECT_NEAR(ahead.seconds_left.value(), 48, 1e-9);
}

TEST(StopRule, noise_waits_until_the_bias_is_known_to_be_on_one_side_of_its_limit) {
  const StopRule rule{std::nullopt, 0.01, 0.05};
  integrate::PassProgress pass = after(10, 0.01);
  EXPECT_EQ(reason(outlook(rule, pass, 20)), "noise") << "nothing estimates the bias";
  pass.excess = integrate::Brightening{-0.03, 0.011};
  EXPECT_EQ(reason(outlook(rule, pass, 20)), "");
  pass.excess->error = 0.009;
  EXPECT_EQ(reason(outlook(rule, pass, 20)), "noise");
  pass.bias = integrate::MeasuredBias{{0.08, 0.02}, 100};  // by whole paths, so it counts instead
  EXPECT_EQ(reason(outlook(rule, pass, 20)), "");
  pass.bias->error = 0.01;
  EXPECT_EQ(reason(outlook(rule, pass, 20)), "noise") << "more samples would not bring it below";
  pass.bias = integrate::MeasuredBias{};
  EXPECT_FALSE(StopRule::is_within(*pass.bias, 0.05)) << "no path was measured";
  EXPECT_EQ(reason(outlook(rule, pass, 20)), "noise");
  pass = after(102, 0.01);
  pass.excess = integrate::Brightening{0, 0.1};
  EXPECT_EQ(reason(outlook(rule, pass, 20)), "samples");
}

/// Seconds of each pass of three renders that began with an empty table (two cores that others were busy on): the first
/// sample a pixel in passes of 1/64, 1/16, 1/4 and the rest of the picture, 23 more after it.
struct Recorded {
  const char* scene;
  double pixels;
  std::vector<double> seconds;
};
const std::vector<Recorded> recorded{
    {"demo", 98304, {0.13, 0.36, 1.03, 2.13, 2.11, 1.73, 1.84, 2.09, 2.09, 1.49, 1.77, 1.26, 1.37, 1.72,
                     1.63, 1.86, 2.11, 2.07, 2.15, 2.3,  2.32, 2.38, 2.45, 2.43, 2.61, 2.4,  2.66}},
    {"fur_ball", 40000, {0.18, 0.52, 1.32, 3.01, 2.83, 1.81, 1.49, 1.43, 1.37, 1.31, 1.36, 1.25, 1.24, 1.31,
                         1.58, 1.53, 1.4,  1.52, 1.53, 1.5,  1.49, 1.44, 1.52, 1.71, 1.71, 1.77, 1.57}},
    {"wavy", 40000, {0.37, 0.8,  2.53, 5.28, 4.6,  3.32, 3.16, 2.89, 2.77, 2.7,  2.74, 2.68, 2.56, 2.29,
                     2.95, 3.02, 3.49, 3.22, 3.49, 3.7,  4.15, 3.95, 4.04, 3.84, 3.86, 4.15, 3.97}}};

TEST(StopRule, the_time_left_is_shown_within_a_factor_of_two_or_not_at_all) {
  const double share[] = {1.0 / 64, 1.0 / 16, 1.0 / 4, 43.0 / 64};
  for (const Recorded& render : recorded) {
    double whole = 0, elapsed = 0, paths = 0;
    for (const double seconds : render.seconds) whole += seconds;
    Forecast forecast({});
    double shown_from = 1;
    for (std::size_t i = 0; i + 1 < render.seconds.size(); ++i) {
      integrate::PassProgress pass;
      pass.pass = static_cast<int>(i);
      pass.pass_count = static_cast<int>(render.seconds.size());
      pass.paths_total = static_cast<std::uint64_t>(24 * render.pixels);
      pass.pixels = static_cast<std::uint64_t>(i < 4 ? share[i] * render.pixels : render.pixels);
      paths += static_cast<double>(pass.pixels);
      pass.paths_so_far = static_cast<std::uint64_t>(paths);
      pass.seconds = render.seconds[i];
      pass.table.queries = 1;  // there are rows
      elapsed += render.seconds[i];
      const Outlook ahead = forecast.after(pass, elapsed);
      if (!ahead.seconds_left) continue;
      shown_from = std::min(shown_from, elapsed / whole);
      EXPECT_LT(*ahead.seconds_left, 2 * (whole - elapsed)) << render.scene << ", pass " << i;
      EXPECT_GT(*ahead.seconds_left, (whole - elapsed) / 2) << render.scene << ", pass " << i;
    }
    EXPECT_LT(shown_from, 0.3) << render.scene << ": shown too late to be of use";
  }
}

}  // namespace
}  // namespace tress::cli
