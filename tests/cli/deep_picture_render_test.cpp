// tress render --deep: the deep picture beside the picture.
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "cli/run_tress.h"
#include "image/picture.h"
#include "support/deep_reader.h"

namespace tress::test {
namespace {

using ::testing::HasSubstr;

/// Hair about a square that stands in the middle of it, with a light that the camera sees.
class DeepRender : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    write_text(path("square.obj"), "v -3 0 -3\nv 3 0 -3\nv 3 0 3\nv -3 0 3\nf 1 2 3 4\n");
    write_text(path("scene.json"), R"({
      "camera": {"frame": true},
      "image": {"width": 40, "height": 30, "samples": 32},
      "environment": {"constant": [0.2, 0.3, 0.4]},
      "lights": [{"sphere": {"center": [2, -4, 2], "radius_cm": 1, "radiance": [3, 2, 1]}, "visible": true}],
      "materials": [{"name": "brown"}],
      "meshes": [{"file": "square.obj"}],
      "grooms": [{"generate": "straight", "strands": 800, "radius_cm": 0.02, "material": "brown"}]
    })");
  }

  void render_well(const std::string& name, std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"render", path("scene.json"), "-o", path(name + ".exr"), "--precision", "float"});
    const Outcome outcome = run(more);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
  }

  static void expect_same_samples(const ReadDeep& a, const ReadDeep& b) {
    ASSERT_EQ(a.pixels.size(), b.pixels.size());
    for (std::size_t i = 0; i < a.pixels.size(); ++i) {
      ASSERT_EQ(a.pixels[i].size(), b.pixels[i].size()) << i;
      const std::size_t bytes = a.pixels[i].size() * sizeof(image::DeepSample);
      EXPECT_TRUE(bytes == 0 || std::memcmp(a.pixels[i].data(), b.pixels[i].data(), bytes) == 0) << i;
    }
  }

  /// Every pixel flattens to the picture's; depths ascend, and contain the picture's Z. Returns the largest difference
  /// relative to the mean of R, G, B, or of A.
  static double flattening_error(const ReadDeep& deep, const image::Picture& picture) {
    EXPECT_EQ(deep.window, picture.window());
    constexpr std::array<const char*, 4> names{"R", "G", "B", "A"};
    double mean = 0, worst = 0;
    for (std::size_t c = 0; c < 3; ++c)
      for (const float x : picture.find(names[c])->pixels)
        mean += static_cast<double>(x) / (3 * static_cast<double>(deep.pixels.size()));
    EXPECT_GT(mean, 0);
    for (std::size_t i = 0; i < deep.pixels.size(); ++i) {
      const std::vector<image::DeepSample>& samples = deep.pixels[i];
      EXPECT_LE(samples.size(), 8u);
      for (std::size_t s = 0; s < samples.size(); ++s) {
        EXPECT_LE(samples[s].front_cm, samples[s].back_cm);
        EXPECT_GT(samples[s].alpha, 0);
        EXPECT_LE(samples[s].alpha, 1);
        if (s > 0) {
          EXPECT_GT(samples[s].front_cm, samples[s - 1].back_cm);
        }
      }
      if (const float z = picture.find("Z")->pixels[i]; z > 0) {
        EXPECT_LE(samples.front().front_cm, z * 1.00001f);
        EXPECT_GE(samples.back().back_cm, z * 0.99999f);
      }
      const std::array<float, 4> values = flat(samples);
      for (std::size_t c = 0; c < 4; ++c) {
        const double apart = std::abs(static_cast<double>(values[c]) - picture.find(names[c])->pixels[i]);
        worst = std::max(worst, c < 3 ? apart / mean : apart);
      }
    }
    return worst;
  }
};

TEST_F(DeepRender, FlattensToTheBeautyWithAnyNumberOfThreadsAndLeavesItAsItIs) {
  constexpr float farthest = std::numeric_limits<float>::max();
  for (const bool transparent : {false, true}) {
    std::vector<std::string> more{"--threads", "1"};
    if (transparent) more.emplace_back("--transparent");
    render_well("plain", more);
    more.insert(more.end(), {"--deep", path("one.deep.exr")});
    render_well("one", more);
    more[1] = "2";
    more.back() = path("two.deep.exr");
    render_well("two", more);
    EXPECT_EQ(run_json({"diff", path("plain.exr"), path("one.exr"), "--json"}).at("identical"), true);
    const ReadDeep one = read_deep(path("one.deep.exr"));
    expect_same_samples(one, read_deep(path("two.deep.exr")));
    const auto picture = image::read_exr(path("one.exr"));
    ASSERT_TRUE(picture);
    // Eight roundings of a float, to 6e-8, of alpha and as many of light; single pixels are up to 20 times the mean.
    EXPECT_LT(flattening_error(one, *picture), 2e-5);
    EXPECT_EQ(one.metadata.at("seed"), picture->metadata.at("seed"));
    EXPECT_EQ(one.metadata.at("tress_version"), picture->metadata.at("version"));
    EXPECT_EQ(std::ranges::count_if(one.metadata, [](const auto& x) { return x.first.starts_with("cryptomatte"); }), 0);
    std::size_t most = 0, infinite = 0;
    for (const auto& samples : one.pixels) {
      most = std::max(most, samples.size());
      infinite += !samples.empty() && samples.back().back_cm == farthest;
    }
    EXPECT_EQ(most, 8u) << "some pixel has more than it can keep";
    EXPECT_EQ(infinite > 0, !transparent) << "the background is farthest";
  }
}

TEST_F(DeepRender, OfACropHasItsWindow) {
  render_well("part", {"--crop", "10,5,30,25", "--deep", path("part.deep.exr")});
  const ReadDeep deep = read_deep(path("part.deep.exr"));
  EXPECT_EQ(deep.window, (image::Window{10, 5, 20, 20}));
  EXPECT_EQ(deep.whole_width, 40);
  EXPECT_EQ(deep.whole_height, 30);
  EXPECT_LT(flattening_error(deep, *image::read_exr(path("part.exr"))), 2e-5) << "as above";
}

TEST_F(DeepRender, RefusesWhatItCannotWrite) {
  const auto refused = [&](std::vector<std::string> more, int status) {
    more.insert(more.begin(), {"render", path("scene.json"), "-o", path("a.exr"), "--spp", "1"});
    const Outcome outcome = run(more);
    EXPECT_EQ(outcome.status, status) << outcome.err;
    EXPECT_FALSE(fs::exists(path("a.exr")));
    return outcome.err;
  };
  EXPECT_THAT(refused({"--deep", path("nowhere/a.exr")}, 1), HasSubstr("nowhere"));
  EXPECT_THAT(refused({"--deep", path("deep.png")}, 2), HasSubstr("--deep"));
  EXPECT_THAT(refused({"--deep", path("a.exr")}, 2), HasSubstr("different files"));
  EXPECT_THAT(refused({"--deep", path("deep.exr"), "--part", path("a.part")}, 2), HasSubstr("--deep"));
}

}  // namespace
}  // namespace tress::test
