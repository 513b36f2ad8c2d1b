// What the filter of half pictures must do on pictures whose truth is known.
#include "denoise/half_filter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <functional>
#include <random>
#include <string>

namespace tress::denoise {
namespace {

using ::testing::HasSubstr;

constexpr int side = 48;

using Truth = std::function<float(int, int)>;

image::Channel channel(const std::string& name, const Truth& value) {
  image::Channel made{name, {}};
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) made.pixels.push_back(value(x, y));
  return made;
}

/// Upright strands in a parallel view, each pixel `truth` and, in both halves, Gaussian noise of this deviation.
image::Picture picture_of(const Truth& truth, float noise) {
  image::Picture picture;
  picture.width = picture.height = side;
  picture.matrices["worldToCamera"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  picture.matrices["worldToNDC"] = picture.matrices["worldToCamera"];
  std::mt19937 random(7);
  std::normal_distribution<float> normal;
  for (const std::string c : {"R", "G", "B"}) {
    const auto noisy = [&](int x, int y) { return truth(x, y) + noise * normal(random); };
    const image::Channel a = channel("half_a." + c, noisy), b = channel("half_b." + c, noisy);
    picture.channels.push_back(channel(c, [&](int x, int y) {
      const auto i = static_cast<std::size_t>(y * side + x);
      return 0.5f * a.pixels[i] + 0.5f * b.pixels[i];
    }));
    picture.channels.push_back(a);
    picture.channels.push_back(b);
    for (const char* half : {"half_a_variance.", "half_b_variance."})
      picture.channels.push_back(channel(half + c, [&](int, int) { return noise * noise; }));
  }
  for (const std::string c : {"X", "Y", "Z"})
    picture.channels.push_back(channel("tangent." + c, [&](int, int) { return c == "Y" ? 1.0f : 0.0f; }));
  return picture;
}

double error_of(const image::Picture& picture, const Truth& truth) {
  double sum = 0;
  for (const char* c : {"R", "G", "B"}) {
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        const double apart = picture.find(c)->pixels[static_cast<std::size_t>(y * side + x)] - truth(x, y);
        sum += apart * apart / (3.0 * side * side);
      }
    }
  }
  return sum;
}

float columns(int x, int) { return x % 4 < 2 ? 1.0f : 0.4f; }
float rows(int x, int y) { return columns(y, x); }
float checkers(int x, int y) { return (x + y) % 2 == 0 ? 1.0f : 0.2f; }

TEST(HalfFilter, TakesNoiseAlongStrandsAndTellsWhatIsLeft) {
  const image::Picture noisy = picture_of(columns, 0.4f);
  const Result<Denoised> found = denoise(noisy, "a.exr");
  ASSERT_TRUE(found) << found.error().message();
  const double before = error_of(noisy, columns), after = error_of(found->picture, columns);
  EXPECT_LT(after, before / 4);
  EXPECT_NEAR(found->error_before, before, 0.1 * before);
  EXPECT_NEAR(found->error_after, after, 0.4 * after);
  EXPECT_NEAR(found->brightness, 0, 0.01);
  for (const image::Channel& one : found->picture.channels) {
    EXPECT_THAT(one.name, ::testing::Not(HasSubstr("variance"))) << "of noise that is no longer there";
    EXPECT_THAT(one.name, ::testing::Not(HasSubstr("half")));
  }
}

TEST(HalfFilter, GivesThePictureBackWhereItWouldBlurMoreThanItGains) {
  for (const Truth& truth : {Truth(rows), Truth(checkers)}) {
    const image::Picture noisy = picture_of(truth, 0.02f);
    const Result<Denoised> found = denoise(noisy, "a.exr");
    ASSERT_TRUE(found);
    EXPECT_LT(error_of(found->picture, truth), 1.05 * error_of(noisy, truth));
  }
  const Result<Denoised> still = denoise(picture_of(checkers, 0), "a.exr");
  ASSERT_TRUE(still);
  EXPECT_EQ(error_of(still->picture, checkers), 0);
  EXPECT_EQ(still->error_after, 0);
}

TEST(HalfFilter, FollowsTheTangent) {
  image::Picture level = picture_of(rows, 0.4f);
  const double upright = error_of(denoise(level, "a.exr")->picture, rows);
  std::swap(const_cast<image::Channel*>(level.find("tangent.X"))->pixels,
            const_cast<image::Channel*>(level.find("tangent.Y"))->pixels);
  EXPECT_LT(error_of(denoise(level, "a.exr")->picture, rows), 0.6 * upright);
}

TEST(HalfFilter, HasTheSameBitsForAnyNumberOfThreads) {
  const image::Picture noisy = picture_of(columns, 0.4f);
  const Result<Denoised> many = denoise(noisy, "a.exr");
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const Result<Denoised> alone = denoise(noisy, "a.exr");
  ASSERT_TRUE(many && alone);
  EXPECT_TRUE(image::compare(many->picture, alone->picture, "a", "b")->identical);
}

TEST(HalfFilter, LargestFloatsStayFinite) {
  const Result<Denoised> found = denoise(picture_of([](int x, int) { return x == 9 ? 3e38f : 0.0f; }, 0), "a.exr");
  ASSERT_TRUE(found);
  for (const image::Channel& one : found->picture.channels)
    for (const float value : one.pixels) ASSERT_TRUE(std::isfinite(value)) << one.name;
}

TEST(HalfFilter, NamesWhatIsMissingAndHowToGetIt) {
  image::Picture without = picture_of(columns, 0.4f);
  std::erase_if(without.channels, [](const image::Channel& one) { return one.name == "half_b.R"; });
  const Result<Denoised> refused = denoise(without, "a.exr");
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message(), HasSubstr("a.exr: layers: expected"));
  EXPECT_THAT(refused.error().message(), HasSubstr("tress render --layers"));
  EXPECT_THAT(refused.error().message(), HasSubstr("no half_b.R"));
  image::Picture few = picture_of(columns, 0.4f);
  for (image::Channel& one : few.channels)
    if (one.name.find("variance") != std::string::npos) one.pixels.assign(one.pixels.size(), 0.0f);
  ASSERT_FALSE(denoise(few, "a.exr"));
  EXPECT_THAT(denoise(few, "a.exr").error().message(), HasSubstr("4 samples a pixel"));
  image::Picture foreign = picture_of(columns, 0.4f);
  foreign.matrices.clear();
  ASSERT_FALSE(denoise(foreign, "a.exr"));
  EXPECT_THAT(denoise(foreign, "a.exr").error().message(), HasSubstr("worldToCamera"));
}

}  // namespace
}  // namespace tress::denoise
