// What the filter of half pictures must do on pictures whose truth is known.
#include "denoise/half_filter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "denoise/denoised_layer.h"

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
image::Picture picture_of(const Truth& truth, float noise, unsigned seed = 7) {
  image::Picture picture;
  picture.width = picture.height = side;
  picture.matrices["worldToCamera"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  picture.matrices["worldToNDC"] = picture.matrices["worldToCamera"];
  std::mt19937 random(seed);
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

TEST(HalfFilter, TakesNoiseAlongStrandsAndReportsWhatIsLeft) {
  const image::Picture noisy = picture_of(columns, 0.4f);
  const Result<Denoised> found = denoise(noisy, "a.exr");
  ASSERT_TRUE(found) << found.error().message();
  const double before = error_of(noisy, columns), after = error_of(with_filtered(noisy, *found), columns);
  EXPECT_LT(after, before / 4);
  EXPECT_NEAR(found->error_before, before, 0.1 * before);
  EXPECT_NEAR(found->error_after, after, 0.4 * after);
  EXPECT_NEAR(found->brightness, 0, 0.01);
  const image::Picture clean = with_filtered(noisy, *found);
  for (const image::Channel& one : clean.channels) {
    EXPECT_THAT(one.name, ::testing::Not(HasSubstr("variance"))) << "of noise that is no longer there";
    EXPECT_THAT(one.name, ::testing::Not(HasSubstr("half")));
  }
}

// Columns that change along their length too, at noise in which their likeness is a guess: there the weights follow
// noise, which looks like a gain. Without luck_of_weights() the ratios are 0.84 and 0.93. Measured over 40 pictures:
// 1.006 and 1.002.
TEST(HalfFilter, TheErrorThatItReportsIsTheErrorThatIsLeft) {
  const Truth waves = [](int x, int y) {
    return columns(x, y) * (1 + 0.4f * std::sin(0.5f * static_cast<float>(y)) * std::cos(0.3f * static_cast<float>(x)));
  };
  for (const float noise : {0.3f, 0.08f}) {
    double reported = 0, found = 0;
    for (unsigned seed = 1; seed <= 8; ++seed) {
      const image::Picture noisy = picture_of(waves, noise, seed);
      const Result<Denoised> filtered = denoise(noisy, "a.exr");
      ASSERT_TRUE(filtered);
      reported += filtered->error_after;
      found += error_of(with_filtered(noisy, *filtered), waves);
    }
    EXPECT_NEAR(reported / found, 1, 0.06) << noise;
  }
}

// The spread of 60 pictures is known within 9 %, so 30 % is more than three deviations; the seeds are fixed. Of a
// corner the estimate is negative in some pictures: reported as 0, it would end a render that asks for any noise at
// all.
TEST(HalfFilter, KnowsHowWellItEstimatesAndNeverReportsLess) {
  const Truth flat = [](int, int) { return 0.5f; };
  constexpr unsigned pictures = 60;
  double deviations = 0, sum = 0, squares = 0;
  int negative = 0;
  for (unsigned seed = 1; seed <= pictures; ++seed) {
    image::Picture noisy = picture_of(flat, 0.4f, seed);
    const Result<Denoised> whole = denoise(noisy, "a.exr");
    noisy.channels.push_back(channel("coverage", [](int x, int y) { return x < 12 && y < 12 ? 1.0f : 0.0f; }));
    const Result<Denoised> corner = denoise(noisy, "a.exr");
    ASSERT_TRUE(whole && corner);
    deviations += whole->error_after_deviation / pictures;
    sum += whole->error_after / pictures;
    squares += whole->error_after * whole->error_after / pictures;
    negative += corner->error_after < 0 ? 1 : 0;
    EXPECT_GE(corner->noise() * corner->mean, std::sqrt(corner->error_after_deviation) * (1 - 1e-9));
    EXPECT_GT(corner->noise(), 0);
  }
  EXPECT_NEAR(deviations / std::sqrt(squares - sum * sum), 1, 0.3);
  EXPECT_GT(negative, 0);
}

TEST(HalfFilter, CountsWhatIsSeenAlone) {
  image::Picture noisy = picture_of([](int x, int y) { return x < side / 2 ? columns(x, y) : 0.0f; }, 0.2f);
  const double all = denoise(noisy, "a.exr")->noise();
  noisy.channels.push_back(channel("coverage", [](int x, int) { return x < side / 2 ? 1.0f : 0.0f; }));
  const Result<Denoised> half = denoise(noisy, "a.exr");
  ASSERT_TRUE(half);
  EXPECT_LT(half->noise(), 0.9 * all) << "the dark half has as much noise and no light";
  EXPECT_NEAR(half->mean, 0.7, 0.03);
}

TEST(HalfFilter, GivesThePictureBackWhereItWouldBlurMoreThanItGains) {
  for (const Truth& truth : {Truth(rows), Truth(checkers)}) {
    const image::Picture noisy = picture_of(truth, 0.02f);
    const Result<Denoised> found = denoise(noisy, "a.exr");
    ASSERT_TRUE(found);
    EXPECT_LT(error_of(with_filtered(noisy, *found), truth), 1.05 * error_of(noisy, truth));
  }
  const image::Picture noiseless = picture_of(checkers, 0);
  const Result<Denoised> still = denoise(noiseless, "a.exr");
  ASSERT_TRUE(still);
  EXPECT_EQ(error_of(with_filtered(noiseless, *still), checkers), 0);
  EXPECT_EQ(still->error_after, 0);
}

TEST(HalfFilter, FollowsTheTangent) {
  image::Picture level = picture_of(rows, 0.4f);
  const auto filtered = [&] { return error_of(with_filtered(level, *denoise(level, "a.exr")), rows); };
  const double upright = filtered();
  std::swap(const_cast<image::Channel*>(level.find("tangent.X"))->pixels,
            const_cast<image::Channel*>(level.find("tangent.Y"))->pixels);
  EXPECT_LT(filtered(), 0.6 * upright);
}

TEST(HalfFilter, HasTheSameBitsForAnyNumberOfThreads) {
  const image::Picture noisy = picture_of(columns, 0.4f);
  const Result<Denoised> many = denoise(noisy, "a.exr");
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const Result<Denoised> alone = denoise(noisy, "a.exr");
  ASSERT_TRUE(many && alone);
  EXPECT_EQ(many->colors, alone->colors);
  EXPECT_EQ(many->error_after, alone->error_after);
}

TEST(HalfFilter, LargestFloatsStayFinite) {
  const Result<Denoised> found = denoise(picture_of([](int x, int) { return x == 9 ? 3e38f : 0.0f; }, 0), "a.exr");
  ASSERT_TRUE(found);
  for (const std::vector<float>& one : found->colors)
    for (const float value : one) ASSERT_TRUE(std::isfinite(value));
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

TEST(DenoisedLayer, LiesBesideThePicture) {
  const image::Picture noisy = picture_of(columns, 0.4f);
  image::Picture layered = noisy;
  const Result<Denoised> found = add_denoised("a.exr", &layered);
  ASSERT_TRUE(found) << found.error().message();
  for (std::size_t c = 0; c < 3; ++c) {
    const std::string name(1, "RGB"[c]);
    EXPECT_EQ(layered.find(name)->pixels, noisy.find(name)->pixels) << "as rendered";
    EXPECT_EQ(layered.find("denoised." + name)->pixels, found->colors[c]);
  }
  EXPECT_THAT(layered.metadata.at("denoised"), HasSubstr(denoised_words(*found)));
  image::Picture without_halves;
  without_halves.width = without_halves.height = side;
  for (const char* c : {"R", "G", "B"}) without_halves.channels.push_back(channel(c, columns));
  EXPECT_FALSE(add_denoised("a.exr", &without_halves));
  EXPECT_EQ(without_halves.channels.size(), 3u);
  EXPECT_TRUE(without_halves.metadata.empty());
}

}  // namespace
}  // namespace tress::denoise
