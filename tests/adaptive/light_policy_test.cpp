// The policy alone: shares of light, the epsilon that follows from them, and the bound on the picture's error.
#include "table/light_policy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace tress::inline v0_2::adaptive {
namespace {

Options driven_by(double picture_error) {
  Options options;
  options.picture_error = picture_error;
  return options;
}

SliceDescription slice_of(SliceKind kind) {
  SliceDescription slice;
  slice.kind = kind;
  slice.blur_rad = 0.2f;
  return slice;
}

TEST(LightPolicy, WithoutAPictureErrorEachKindHasOneEpsilon) {
  const LightPolicy policy{Options{}};
  EXPECT_FALSE(policy.is_driven());
  EXPECT_EQ(policy.epsilon_of(slice_of(SliceKind::density), fixed_light(1), 1), Options{}.epsilon);
  EXPECT_EQ(policy.epsilon_of(slice_of(SliceKind::samples), 0, 1), Options{}.sampled_epsilon);
}

TEST(LightPolicy, SharesAreLightPerPath) {
  LightPolicy policy{Options{}};
  EXPECT_EQ(policy.share(fixed_light(3)), 3) << "before the first path";
  policy.paths = 4;
  EXPECT_EQ(policy.share(fixed_light(3)), 0.75);
  EXPECT_EQ(policy.share(fixed_light(3), 1), 1);
  EXPECT_EQ(fixed_light(1e9f), fixed_light(4096)) << "no query counts for more";
}

// E8: epsilon_r = (E / (v n s_r))^2 / V_r, with v = 0.1, n nodes and one path more than was seen.
TEST(LightPolicy, EpsilonFollowsTheLightWithinItsLimits) {
  LightPolicy policy{driven_by(0.01)};
  policy.paths = 1000;
  policy.queried = 10;
  const SliceDescription density = slice_of(SliceKind::density), samples = slice_of(SliceKind::samples);
  const double share = (100.0 + 1) / 1000, error = 0.01 / (0.1 * 10 * share);
  const double variation = std::sqrt(std::numbers::pi) / static_cast<double>(density.blur_rad);
  EXPECT_NEAR(policy.epsilon_of(density, fixed_light(100), 1), error * error / variation, 1e-12);
  EXPECT_NEAR(policy.epsilon_of(samples, fixed_light(100), 1), error * error, 1e-12);
  EXPECT_EQ(policy.epsilon_of(density, 0, 1), 1) << "carries next to nothing: its mean will do";
  EXPECT_EQ(policy.epsilon_of(samples, 0, 1), 0.5);
  EXPECT_EQ(policy.epsilon_of(density, fixed_light(4096) * 100, 1), 1e-3);
  EXPECT_EQ(policy.epsilon_of(samples, fixed_light(4096) * 100, 1), 0.005);
}

TEST(LightPolicy, TheBiasOfARowIsItsShareTimesItsError) {
  LightPolicy policy{Options{}};
  policy.paths = 2;
  EXPECT_NEAR(policy.bias_of(slice_of(SliceKind::samples), fixed_light(1), 1, 0.04), 0.5 * 0.2, 1e-12);
  const double variation = 1e-3 / 1e-12;  // of a row without energy, taken as 1e-6
  EXPECT_NEAR(policy.bias_of(slice_of(SliceKind::density), fixed_light(1), 0, 0.04), 0.5 * std::sqrt(variation * 0.04),
              1e-6);
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
