// One picture a model, 32 x 32, against tests/reference/pictures: that no change of a model, of sampling or of the
// renderer goes unseen. Made anew, where a change is meant, by
//   TRESS_MAKE_PICTURES=1 build/release/tests/test_cli_render --gtest_filter='*Golden*'
// What may differ is rounding: other compilers, instruction sets, mathematical libraries, and Embree 3 or 4, whose hits
// differ by some 1e-6. Paths end after two hits, so that it is magnified once only (by the distance of strands over
// their radius, some 100): 1e-4 of the picture's mean. Where it turns a decision (which lobe, hit or miss) a pixel has
// another sample, as good as the first. With radii moved by 3e-6 no pixel of `elliptical` differs by more than 0.001 of
// the mean and 1.4 % of `chiang2016` differ by more than 1e-4. So few pixels differ, and those that do have no common
// direction.
//
// Of `fiber3d`, whose walk over facets decides at every step, all pixels differ that show hair, and `rough` takes the
// same walk, learns rows by it, and may learn them otherwise one day. So theirs are held to the physics and not to the
// draws: means of 4 x 4 pixels against those of renders of other seeds, whose spread says how far they may be apart.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <string>
#include <vector>

#include "cli/run_tress.h"
#include "image/picture.h"
#include "references/registry.h"
#include "support/seed.h"

namespace tress::test {
namespace {

constexpr const char* lock = R"({
  "camera": {"frame": true},
  "image": {"width": 32, "height": 32, "samples": 16},
  "environment": {"studio": true},
  "materials": [{"name": "blond", "eccentricity": 0.75, "roughness": 0.25,
                 "melanin": {"eumelanin": 0.25, "pheomelanin": 0.35}}],
  "grooms": [{"generate": "straight", "strands": 600, "radius_cm": 0.03, "material": "blond"}]
})";

constexpr double same = 1e-3;  // of the picture's mean: ten times what rounding does to a path
constexpr double z_limit = 5;  // of the mean difference: one false alarm in 60,000 runs of nine models, three colors
constexpr double most_others = 0.05;

class GoldenPictures : public CommandTest, public testing::WithParamInterface<std::string> {};

TEST_P(GoldenPictures, AreWhatTheyWereWithinRounding) {
  const std::string model = GetParam();
  const std::filesystem::path file =
      std::filesystem::path(TRESS_SOURCE_DIR "/tests/reference/pictures") / (model + ".exr");
  write_text(path("scene.json"), lock);
  const Outcome outcome =
      run({"render", path("scene.json"), "-o", path("a.exr"), "--model", model, "--max-depth", "2", "--seed", "1",
           "--threads", "2", "--roulette", "throughput", "--precision", "float", "--quiet"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  Result<image::Picture> picture = image::read_exr(path("a.exr"));
  ASSERT_TRUE(picture) << picture.error().message();
  std::erase_if(picture->channels,
                [](const image::Channel& c) { return c.name != "R" && c.name != "G" && c.name != "B"; });
  picture->metadata.clear();
  if (std::getenv("TRESS_MAKE_PICTURES") != nullptr) {
    ASSERT_FALSE(image::write_exr(file, *picture));
  }
  const Result<image::Picture> golden = image::read_exr(file);
  ASSERT_TRUE(golden) << golden.error().message();
  ASSERT_EQ(golden->channels.size(), 3u);
  for (const image::Channel& channel : golden->channels) {
    const std::vector<float>&a = channel.pixels, &b = picture->find(channel.name)->pixels;
    ASSERT_EQ(a.size(), b.size());
    const auto count = static_cast<double>(a.size());
    double mean = 0, difference = 0, squares = 0;
    for (const float value : a) mean += static_cast<double>(value) / count;
    int others = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      const double d = static_cast<double>(b[i]) - static_cast<double>(a[i]);
      difference += d / count;
      squares += d * d;
      others += std::abs(d) > same * mean ? 1 : 0;
    }
    const double share = others / count, error = std::sqrt(squares) / count;
    std::printf("%s %s: a share of %.4f of the pixels differs, the mean by %.2g (standard error %.2g)\n", model.c_str(),
                channel.name.c_str(), share, difference / mean, error / mean);
    EXPECT_GT(mean, 0.01);
    EXPECT_LE(share, most_others) << channel.name;
    EXPECT_LE(std::abs(difference), z_limit * error + 1e-4 * mean) << channel.name;
  }
}

bool walks(const std::string& model) { return model == "fiber3d" || model == "rough"; }

std::vector<std::string> names(bool walking) {
  std::vector<std::string> all;
  for (const fiber::ModelInfo& info : references::models())
    if (walks(std::string(info.name)) == walking) all.emplace_back(info.name);
  return all;
}

std::string name_of(const testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  std::ranges::replace(name, '-', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Models, GoldenPictures, testing::ValuesIn(names(false)), name_of);

constexpr std::size_t blocks_along = 8, pixels_along = 4;
using Blocks = std::array<std::vector<double>, 3>;  ///< means of 4 x 4 pixels, row by row, by channel

/// What renders of one picture by other seeds have, and how another one may differ from them. A mean over blocks or
/// over the picture differs by Student's t of 15 degrees.
struct Spread {
  static constexpr int seeds = 16;
  /// Of the picture: one false alarm in 6,000 a channel. Of a block: in 600,000, one in 3,000 of all of a picture.
  static constexpr double picture_limit = 5, block_limit = 7.5;
  /// Of the picture's mean: in a block that strands hardly touch, 16 renders may not show how far another one may be
  /// off.
  static constexpr double least_block_error = 1e-3;
  std::vector<Blocks> renders;

  /// How far the picture of `other` is off, in standard errors, the worst channel; and the worst of its blocks.
  double of_picture(const Blocks& other) const {
    double worst = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      std::vector<double> means;
      for (const Blocks& render : renders) means.push_back(mean_of(render[c]));
      worst = std::max(worst, off(means, mean_of(other[c]), 0));
    }
    return worst;
  }
  double of_blocks(const Blocks& other) const {
    double worst = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t i = 0; i < other[c].size(); ++i) {
        std::vector<double> values;
        for (const Blocks& render : renders) values.push_back(render[c][i]);
        worst = std::max(worst, off(values, other[c][i], least_block_error * mean_of(other[c])));
      }
    }
    return worst;
  }
  bool accepts(const Blocks& other) const {
    return of_picture(other) < picture_limit && of_blocks(other) < block_limit;
  }
  Blocks mean() const {
    Blocks mean;
    for (std::size_t c = 0; c < 3; ++c) {
      mean[c].resize(blocks_along * blocks_along);
      for (const Blocks& render : renders)
        for (std::size_t i = 0; i < mean[c].size(); ++i) mean[c][i] += render[c][i] / static_cast<double>(seeds);
    }
    return mean;
  }

  static double mean_of(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  }

 private:
  /// least: the least error that is believed.
  static double off(const std::vector<double>& values, double other, double least) {
    const double mean = mean_of(values), count = static_cast<double>(values.size());
    double squares = 0;
    for (const double value : values) squares += (value - mean) * (value - mean);
    return std::abs(other - mean) / std::max(std::sqrt(squares / (count - 1) * (1 + 1 / count)), least);
  }
};

std::size_t upside_down(std::size_t block) {
  return (blocks_along - 1 - block / blocks_along) * blocks_along + block % blocks_along;
}

class GoldenMeans : public CommandTest, public testing::WithParamInterface<std::string> {
 protected:
  static fs::path file(const std::string& model) {
    return fs::path(TRESS_SOURCE_DIR "/tests/reference/pictures") / (model + ".exr");
  }
  static std::string channel(int seed, char color) { return "seed" + std::to_string(seed) + "." + color; }

  Result<Blocks> render(const std::string& model, int seed) {
    write_text(path("scene.json"), lock);
    const Outcome outcome = run({"render", path("scene.json"), "-o", path("a.exr"), "--model", model, "--max-depth",
                                 "2", "--spp", model == "rough" ? "1024" : "4096", "--seed", std::to_string(seed),
                                 "--roulette", "throughput", "--precision", "float", "--quiet"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    const Result<image::Picture> picture = image::read_exr(path("a.exr"));
    if (!picture) return picture.error();
    Blocks blocks;
    for (std::size_t c = 0; c < 3; ++c) {
      blocks[c].resize(blocks_along * blocks_along);
      const std::vector<float>& pixels = picture->find(std::string(1, "RGB"[c]))->pixels;
      for (std::size_t i = 0; i < pixels.size(); ++i) {
        const std::size_t width = blocks_along * pixels_along, x = i % width, y = i / width;
        blocks[c][y / pixels_along * blocks_along + x / pixels_along] +=
            double{pixels[i]} / static_cast<double>(pixels_along * pixels_along);
      }
    }
    return blocks;
  }

  /// Of seeds 101 to 116.
  void make(const std::string& model) {
    image::Picture all;
    all.width = all.height = static_cast<int>(blocks_along);
    for (int seed = 101; seed <= 100 + Spread::seeds; ++seed) {
      const Result<Blocks> blocks = render(model, seed);
      ASSERT_TRUE(blocks) << blocks.error().message();
      for (std::size_t c = 0; c < 3; ++c)
        all.channels.push_back({channel(seed, "RGB"[c]), {(*blocks)[c].begin(), (*blocks)[c].end()}});
    }
    ASSERT_FALSE(image::write_exr(file(model), all));
  }

  static Spread read(const std::string& model) {
    const Result<image::Picture> all = image::read_exr(file(model));
    Spread spread;
    EXPECT_TRUE(all) << all.error().message();
    for (int seed = 101; seed <= 100 + Spread::seeds; ++seed) {
      Blocks& blocks = spread.renders.emplace_back();
      for (std::size_t c = 0; c < 3; ++c) {
        const image::Channel* found = all->find(channel(seed, "RGB"[c]));
        EXPECT_NE(found, nullptr);
        if (found != nullptr) blocks[c].assign(found->pixels.begin(), found->pixels.end());
      }
    }
    return spread;
  }
};

// Seed 1 (TRESS_TEST_SEED gives another).
TEST_P(GoldenMeans, AreThoseOfOtherSeeds) {
  if (std::getenv("TRESS_MAKE_PICTURES") != nullptr) make(GetParam());
  const Spread spread = read(GetParam());
  const Result<Blocks> blocks = render(GetParam(), static_cast<int>(test::seed(1)));
  ASSERT_TRUE(blocks) << blocks.error().message();
  std::printf("%s: the picture is off by %.2f standard errors, a block by %.2f at most\n", GetParam().c_str(),
              spread.of_picture(*blocks), spread.of_blocks(*blocks));
  EXPECT_LT(spread.of_picture(*blocks), Spread::picture_limit);
  EXPECT_LT(spread.of_blocks(*blocks), Spread::block_limit);
  // What it must see, done to this very picture.
  Blocks turned = *blocks, grey = *blocks;
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < turned[c].size(); ++i) turned[c][i] = (*blocks)[c][upside_down(i)];
    std::ranges::fill(grey[c], Spread::mean_of((*blocks)[c]));
  }
  EXPECT_GT(spread.of_blocks(turned), Spread::block_limit);
  EXPECT_GT(spread.of_blocks(grey), Spread::block_limit);
}

// A picture as the others are in the mean, but with a gain. Nothing is drawn.
TEST_P(GoldenMeans, SeesAGainOfTwoPercent) {
  const Spread spread = read(GetParam());
  EXPECT_TRUE(spread.accepts(spread.mean()));
  for (const double gain : {0.97, 0.98, 1.02, 1.03}) {
    Blocks other = spread.mean();
    for (std::vector<double>& channel : other)
      for (double& value : channel) value *= gain;
    EXPECT_GT(spread.of_picture(other), Spread::picture_limit) << gain;
  }
}

INSTANTIATE_TEST_SUITE_P(Models, GoldenMeans, testing::ValuesIn(names(true)), name_of);

}  // namespace
}  // namespace tress::test
