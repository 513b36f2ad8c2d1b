// tress render --near: a fiber that is seen wide has the pattern across it that the traced fiber has, and fibers that
// touch are as bright.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include "cli/run_tress.h"
#include "image/picture.h"
#include "tress/fiber/fiber_model.h"

namespace tress::test {
namespace {

using ::testing::HasSubstr;

/// A fiber of 96 um by 67 um that fills the picture.
constexpr const char* wide_fiber = R"({
  "camera": {"eye": [0, -4, -5], "look_at": [0, 0, -5], "vertical_fov_deg": 0.12},
  "image": {"width": 32, "height": 32, "samples": 256},
  "environment": {"studio": true}, "environment_visible": false,
  "materials": [{"name": "brown", "eccentricity": 0.7, "roughness": 0.15}],
  "grooms": [{"generate": "single_fiber", "radius_cm": 0.004, "material": "brown"}]
})";

class Near : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    write_text(path("scene.json"), wide_fiber);
  }
  /// Means of the columns, which are places across the fiber, by channel.
  std::vector<double> profile(const std::vector<std::string>& options) const {
    std::vector<std::string> command{"render", path("scene.json"), "-o", path("a.exr"), "--quiet"};
    command.insert(command.end(), options.begin(), options.end());
    const Outcome outcome = run(command);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    const auto read = image::read_exr(path("a.exr"));
    EXPECT_TRUE(read);
    std::vector<double> means;
    if (!read) return means;
    const image::Picture& picture = *read;
    for (const image::Channel& channel : picture.channels) {
      if (channel.name != "R" && channel.name != "G" && channel.name != "B") continue;
      for (int x = 0; x < picture.width; ++x) {
        double sum = 0;
        for (int y = 0; y < picture.height; ++y)
          sum += static_cast<double>(channel.pixels[static_cast<std::size_t>(y * picture.width + x)]);
        means.push_back(sum / picture.height);
      }
    }
    return means;
  }
};

double relative_l2(const std::vector<double>& a, const std::vector<double>& b) {
  double off = 0, all = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    off += (a[i] - b[i]) * (a[i] - b[i]);
    all += b[i] * b[i];
  }
  return std::sqrt(off / all);
}

/// Fibers that touch, dark, in a white surround: what an edge reflects leaves where there is no neighbour.
constexpr const char* touching = R"({
  "camera": {"frame": true},
  "image": {"width": 16, "height": 16, "samples": 128},
  %l,
  "materials": [{"name": "m", "eccentricity": 0.8, "roughness": 0.2, %s}],
  "grooms": [{"generate": "straight", "strands": 20000, "radius_cm": 0.03, "material": "m"}]
})";

struct Mean {
  double value = 0, error = 0;  ///< error: standard
};

/// What `info` says of the usual rule, in percent.
struct NearWords {
  double drawn = 0, lost = 0, even = 0;
};

class TouchingFibers : public CommandTest {
 protected:
  static constexpr const char* surround = R"("environment": {"constant": [1, 1, 1]}, "environment_visible": false)";
  void write_scene(const std::string& color, const std::string& light = surround) const {
    std::string text = touching;
    text.replace(text.find("%s"), 2, color);
    text.replace(text.find("%l"), 2, light);
    write_text(path("scene.json"), text);
  }
  image::Picture picture(std::vector<std::string> options) const {
    const std::vector<std::string> plain{"render", path("scene.json"), "-o", path("a.exr"), "--quiet"};
    options.insert(options.begin(), plain.begin(), plain.end());
    const Outcome outcome = run(options);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    auto read = image::read_exr(path("a.exr"));
    EXPECT_TRUE(read);
    return read ? std::move(*read) : image::Picture{};
  }
  static double sum(const image::Picture& picture, const std::string& channel) {
    double sum = 0;
    for (const image::Channel& one : picture.channels)
      if (one.name == channel)
        for (const float x : one.pixels) sum += static_cast<double>(x);
    return sum;
  }
  /// Brightness of the hair, over four seeds. Its error is that of the pictures, of thousands of samples each: the
  /// spread of four seeds would be known to 40 % only.
  Mean brightness(const std::vector<std::string>& options) const {
    double light = 0, hair = 0, variance = 0;
    for (int seed = 1; seed <= 4; ++seed) {
      std::vector<std::string> command = options;
      command.insert(command.end(), {"--seed", std::to_string(seed)});
      const image::Picture made = picture(command);
      light += sum(made, "G");
      hair += sum(made, "A");
      variance += sum(made, "variance.G");
    }
    const Mean mean{light / hair, std::sqrt(variance) / hair};
    std::printf("%.4f +- %.4f\n", mean.value, mean.error);
    return mean;
  }
};

// 4 standard errors: right code fails with a probability of 6e-5 a case. Deeper hits which are not traced may be off by
// 2 % beside that. Of drawn hits rows answer the sampled light, whose weight is at most
// p^4 / (p^4 + q^4) = 0.005, with p = 1/(4 pi) and q = FiberModel::drawn_near_density.
TEST_F(TouchingFibers, AreAsBrightAsTracedOnes) {
  write_scene(R"("melanin": {"eumelanin": 8})");
  const Mean truth = brightness({"--model", "fiber3d", "--spp", "512"}), touching = brightness({"--near", "touching"}),
             everywhere = brightness({"--near", "everywhere"}), nowhere = brightness({"--near", "nowhere"});
  const auto error = [&](const Mean& mean) { return 4 * std::hypot(mean.error, truth.error); };
  EXPECT_NEAR(everywhere.value, truth.value, error(everywhere));
  EXPECT_NEAR(touching.value, truth.value, error(touching) + 0.02 * truth.value);
  EXPECT_LT(nowhere.value, 0.95 * truth.value);
  const Mean usual = brightness({});
  const double p = 1 / (4 * std::numbers::pi), q = double{fiber::FiberModel::drawn_near_density};
  const double of_rows = (truth.value - nowhere.value) / (1 + std::pow(q / p, 4));
  EXPECT_NEAR(usual.value, truth.value, error(usual) + 0.02 * truth.value + of_rows);
}

// All light comes back from clear fibers, wherever their hits are traced. A part of 1e-3 is the rows'. Right code fails
// with a probability of 3e-4 in the four cases (over 32 seeds the spread is 0.86 of the error that pictures report).
TEST_F(TouchingFibers, AreWhiteInAFurnace) {
  write_scene(R"("sigma_a": [0, 0, 0])");
  for (const char* where : {"2", "touching", "everywhere", "nowhere"}) {
    const Mean mean = brightness({"--near", where, "--spp", "16", "--max-depth", "4096"});
    EXPECT_NEAR(mean.value, 1, 4 * mean.error + 2e-3) << where;
  }
}

TEST_F(TouchingFibers, AreTheSameForAnyNumberOfThreads) {
  write_scene(R"("melanin": {"eumelanin": 1})");
  const auto by = [&](const char* near, const char* threads) {
    return picture({"--spp", "8", "--near", near, "--threads", threads});
  };
  for (const char* near : {"2", "touching"}) {
    const image::Picture one = by(near, "1"), two = by(near, "2");
    ASSERT_EQ(one.channels.size(), two.channels.size());
    for (std::size_t i = 0; i < one.channels.size(); ++i)
      EXPECT_TRUE(one.channels[i].pixels == two.channels[i].pixels) << near << ' ' << one.channels[i].name;
    EXPECT_THAT(one.metadata.at("near"), HasSubstr("of the hits where they touch"));
  }
  const image::Picture seen = by("seen", "2"), nowhere = by("nowhere", "2");
  EXPECT_THAT(seen.metadata.at("near"), HasSubstr("fibers touch, where rows may be too dark"));
  for (std::size_t i = 0; i < seen.channels.size(); ++i)
    EXPECT_TRUE(seen.channels[i].pixels == nowhere.channels[i].pixels) << seen.channels[i].name;
}

constexpr const char* sun =
    R"("environment": {"constant": [0, 0, 0]}, "environment_visible": false, "lights": [{"distant": {"azimuth_deg": 60, "elevation_deg": 35, "irradiance": [3, 3, 3]}}])";

// Dark fibers lose light to rows, white ones do not. Drawn directions see even light and a wall, but no sun.
TEST_F(TouchingFibers, AreDrawnNearWhereRowsLoseLight) {
  const auto near = [&](const char* color, const std::string& light) {
    write_scene(color, light);
    const Outcome outcome = run({"info", path("scene.json")});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    NearWords found;
    const std::size_t drawn = outcome.out.find("but for small lights at "), lost = outcome.out.find("rows lose ");
    if (drawn != std::string::npos) {
      EXPECT_EQ(std::sscanf(outcome.out.c_str() + drawn, "but for small lights at %lf %%", &found.drawn), 1);
    }
    EXPECT_NE(lost, std::string::npos) << outcome.out;
    if (lost != std::string::npos) {
      constexpr const char* words = "rows lose about %lf %% of the light there, of which %lf %%";
      EXPECT_EQ(std::sscanf(outcome.out.c_str() + lost, words, &found.lost, &found.even), 2);
    }
    return found;
  };
  const char *dark = R"("melanin": {"eumelanin": 8})", *white = R"("sigma_a": [0, 0, 0])";
  const NearWords even = near(dark, surround), lamp = near(dark, sun), bright = near(white, surround);
  EXPECT_EQ(even.drawn, 100);
  EXPECT_EQ(even.even, 100);
  EXPECT_GT(even.lost, 5);  // as AreAsBrightAsTracedOnes has it
  EXPECT_EQ(lamp.drawn, 0);
  EXPECT_EQ(lamp.even, 0);
  EXPECT_LT(bright.lost, 0.3 * even.lost);
  EXPECT_EQ(bright.drawn, 0);
  write_text(path("wall.obj"), "v -90 40 -90\nv 90 40 -90\nv 90 40 90\nv -90 40 90\nf 1 2 3 4\n");
  const NearWords wall = near(dark, std::string(sun) + R"(, "meshes": [{"file": "wall.obj", "albedo": [1, 1, 1]}])");
  EXPECT_GT(wall.even, 10);
  EXPECT_LT(wall.even, 60);
}

// Drawn directions do not see a sun, so none is drawn near; traced hits have six times the variance of rows there.
TEST_F(TouchingFibers, AreAnsweredByRowsUnderASmallLight) {
  write_scene(R"("melanin": {"eumelanin": 1.3})", sun);
  const image::Picture usual = picture({"--spp", "32"}), seen = picture({"--near", "seen", "--spp", "32"}),
                       traced = picture({"--near", "touching", "--spp", "32"});
  for (std::size_t i = 0; i < usual.channels.size(); ++i)
    EXPECT_TRUE(usual.channels[i].pixels == seen.channels[i].pixels) << usual.channels[i].name;
  const auto noise = [](const image::Picture& made) { return std::stod(made.metadata.at("noise")); };
  EXPECT_LT(noise(usual), 0.8 * noise(traced));
}

// Where all hits are traced, those that are audited and those that are not have one mean. Rows without audits are some
// 3 % darker here (8 seeds). One seed is within 3 reported errors with a probability of 0.997.
TEST_F(TouchingFibers, HaveNoBiasWhereAllHitsAreTraced) {
  write_scene(R"("melanin": {"eumelanin": 2})");
  const image::Picture made = picture({"--near", "everywhere", "--measure-bias", "0.3", "--spp", "64"});
  double bias = 1, error = 0;
  ASSERT_EQ(std::sscanf(made.metadata.at("bias").c_str(), "%lf +- %lf", &bias, &error), 2);
  EXPECT_GT(error, 0);
  EXPECT_LT(std::abs(bias), 3 * error);
}

// --noise ends at the noise that it was given, and at the truth within 3 reported errors, beside the 2 % of deeper hits
// that are not traced.
TEST_F(TouchingFibers, EndAtTheNoiseThatWasAskedFor) {
  write_scene(R"("melanin": {"eumelanin": 2})");
  const image::Picture made = picture({"--near", "touching", "--noise", "0.15"});
  EXPECT_LE(std::stod(made.metadata.at("noise")), 0.15);
  const Mean truth = brightness({"--model", "fiber3d", "--spp", "512"});
  const double found = sum(made, "G") / sum(made, "A"), error = std::sqrt(sum(made, "variance.G")) / sum(made, "A");
  EXPECT_NEAR(found, truth.value, 3 * std::hypot(error, truth.error) + 0.02 * truth.value);
}

// A column is the mean of 8,192 samples of the truth, by 256 x 32 of ours; reported noise of a pixel of 256 samples is
// 0.1 to 0.2, so that a column is off by 0.02 to 0.04. A row, which is the mean over the width, is off by 0.3 and more.
TEST_F(Near, AWideFiberHasThePatternOfTheTracedOne) {
  const std::vector<double> truth = profile({"--model", "fiber3d"});
  EXPECT_LT(relative_l2(profile({}), truth), 0.1);
  EXPECT_GT(relative_l2(profile({"--near", "0"}), truth), 0.2);
}

TEST_F(Near, AsksForAModelThatTracesItsFibers) {
  const Outcome outcome =
      run({"render", path("scene.json"), "-o", path("a.exr"), "--quiet", "--near", "2", "--model", "elliptical"});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_THAT(outcome.err, HasSubstr("--near: expected a model with rows that can trace its fibers"));
}

TEST_F(Near, WarnsOfAKeyThatTheModelLeavesOut) {
  const Outcome outcome = run({"render", path("scene.json"), "-o", path("a.exr"), "--spp", "1", "--set",
                               "integrator/near=touching", "--model", "elliptical"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("/integrator/near: left out by model elliptical"));
}

TEST_F(Near, LeavesThePictureOfNarrowFibersAsItIs) {
  std::vector<std::string> small{"--resolution", "3x3", "--spp", "4"};
  const auto with = [&](const char* near) {
    std::vector<std::string> command = small;
    command.insert(command.end(), {"--near", near});
    return profile(command);
  };
  EXPECT_NE(profile(small), with("0")) << "it is 3.4 pixels wide";
  EXPECT_EQ(profile(small), with("2"));
  EXPECT_EQ(with("4"), with("nowhere"));
}

TEST_F(Near, SaysWhatItExpects) {
  const Outcome outcome = run({"render", path("scene.json"), "-o", path("a.exr"), "--near", "somewhere"});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_THAT(outcome.err,
              HasSubstr("--near: expected nowhere, seen, touching, everywhere, or 0..1000000, found somewhere"));
}

}  // namespace
}  // namespace tress::test
