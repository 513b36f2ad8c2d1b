// The sketch merges by minimum, in any order, from any number of threads; coverage leaves no wide gap.
#include "observations/sketch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <thread>

#include "properties/property.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr double pi = std::numbers::pi;
constexpr std::uint32_t bins = 128;

void fill(Sketch& sketch, std::uint64_t seed, int first, int last) {
  for (int i = first; i < last; ++i) {
    RandomStream random(seed, static_cast<std::uint64_t>(i));
    const float x = 20 * random.next() - 10;
    sketch.offer(x, random.next());
  }
}

TEST(Sketch, IsTheSameFromEightThreadsAsFromOne) {
  Sketch one(bins), eight(bins);
  fill(one, 9, 0, 80000);
  std::vector<std::thread> threads;
  for (int t = 0; t < 8; ++t) {
    threads.emplace_back([&eight, t] { fill(eight, 9, 10000 * t, 10000 * (t + 1)); });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(one.bins(), eight.bins());
  EXPECT_EQ(one.occupied(), bins);
}

TEST(Sketch, GivesBackWhatItKept) {
  Sketch sketch(bins);
  const float x = 1.2345f;
  sketch.offer(x, 0.75f);
  sketch.offer(-std::numbers::pi_v<float>, 0.25f);
  const auto pairs = sketch.pairs();
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_EQ(pairs[1].g, 0.75f);
  EXPECT_NEAR(pairs[1].azimuth, x, 1.2e-7);  // an ulp
  EXPECT_NEAR(pairs[0].azimuth, -pi, 3e-7);
}

TEST(Sketch, KeepsTheNearestToTheCentre) {
  Sketch sketch(bins);
  const auto centre = static_cast<float>(pi / bins);
  sketch.offer(centre + 0.01f, 1.0f);
  sketch.offer(centre - 0.002f, 2.0f);
  sketch.offer(centre + 0.003f, 3.0f);
  ASSERT_EQ(sketch.pairs().size(), 1u);
  EXPECT_EQ(sketch.pairs()[0].g, 2.0f);
}

TEST(Sketch, IgnoresJunk) {
  Sketch sketch(bins);
  sketch.offer(NAN, 1.0f);
  sketch.offer(1.0f, NAN);
  sketch.offer(1.0f, -1.0f);
  sketch.merge({{bins, 0}, {3, 0x7fc00000}});
  EXPECT_EQ(sketch.occupied(), 0u);
}

TEST(Sketch, BinCountFollowsTheBlur) {
  EXPECT_EQ(Sketch::bin_count(0.785f), 128u);
  EXPECT_EQ(Sketch::bin_count(0.0872665f), static_cast<std::uint32_t>(std::ceil(12 * pi / 0.0872665f)));
}

RC_GTEST_PROP(Coverage, LeavesNoGapWiderThanTwoAndAHalfSigma, (std::uint64_t seed)) {
  const auto count = *rc::gen::inRange(0, 40);
  RandomStream random(seed);
  const float sigma = 0.01f + 0.8f * random.next();
  std::vector<float> all;
  std::vector<ObservedPair> pairs;
  for (int i = 0; i < count; ++i) all.push_back(6.2f * random.next() * random.next() - 3.1f);
  std::sort(all.begin(), all.end());
  for (const float x : all) pairs.push_back({x, 1.0f});
  const auto added = gap_fill_azimuths(pairs, sigma);
  all.insert(all.end(), added.begin(), added.end());
  std::sort(all.begin(), all.end());
  RC_ASSERT(all.front() >= -std::numbers::pi_v<float> && all.back() < std::numbers::pi_v<float>);
  double widest = all.front() + 2 * pi - all.back();
  for (std::size_t i = 1; i < all.size(); ++i) widest = std::max<double>(widest, all[i] - all[i - 1]);
  RC_ASSERT(widest <= 2.5 * sigma + 1e-6);
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
