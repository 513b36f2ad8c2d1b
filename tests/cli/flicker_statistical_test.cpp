// A turntable whose tables are learned flickers no more than one that is traced: temporal variance against `exact`. The
// same at the size of a shot: bench/shots/turntable.py.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "cli/run_tress.h"
#include "image/picture.h"
#include "support/seed.h"

namespace tress::test {
namespace {

constexpr int frames = 6, blocks = 4;
/// Of the logarithm of a ratio of variances, nearly normal: one of four ways is beyond it once in 8,000 runs.
constexpr double z_limit = 4;

using Blocks = std::vector<double>;

/// Mean luminance of 4 x 4 blocks.
Blocks blocks_of(const image::Picture& picture) {
  Blocks sum(blocks * blocks);
  const auto add = [&](const char* channel, double weight) {
    const std::vector<float>& pixels = picture.find(channel)->pixels;
    for (int y = 0; y < picture.height; ++y)
      for (int x = 0; x < picture.width; ++x)
        sum[static_cast<std::size_t>(y * blocks / picture.height * blocks + x * blocks / picture.width)] +=
            weight * static_cast<double>(pixels[static_cast<std::size_t>(y * picture.width + x)]);
  };
  add("R", 0.2126);
  add("G", 0.7152);
  add("B", 0.0722);
  return sum;
}

/// How the blocks of a way move from frame to frame, each over that of the reference.
struct Moves {
  double sum = 0, squares = 0;  ///< of the variances of the blocks about their means over the frames

  Moves(const std::vector<Blocks>& way, const std::vector<Blocks>& reference) {
    for (std::size_t b = 0; b < way[0].size(); ++b) {
      double mean = 0, variance = 0;
      for (std::size_t f = 0; f < frames; ++f) mean += way[f][b] / reference[f][b] / frames;
      for (std::size_t f = 0; f < frames; ++f)
        variance += std::pow(way[f][b] / reference[f][b] - mean, 2) / (frames - 1);
      sum += variance;
      squares += variance * variance;
    }
  }
  /// Degrees of freedom of the sum (Satterthwaite 1946); the mean of a squared variance is 1 + 2 / n of its own square.
  double degrees() const {
    constexpr double of_one = frames - 1;
    return std::clamp(of_one * sum * sum / squares * (1 + 2 / of_one), of_one, of_one * blocks * blocks);
  }
};

class Flicker : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    write_text(path("turn.json"), fmt::format(R"({{
      "camera": {{"turntable": {{"frames": {}, "look_at": [0, 0, -9], "distance_cm": 40}}}},
      "image": {{"width": 24, "height": 24, "samples": 8}},
      "environment": {{"studio": true}},
      "materials": [{{"name": "brown", "eccentricity": 0.85, "roughness": 0.2}}],
      "grooms": [{{"generate": "straight", "strands": 800, "radius_cm": 0.03, "material": "brown"}}]
    }})",
                                              frames));
  }
  /// Frame by frame, each with a seed of its own.
  std::vector<Blocks> render(std::uint64_t stream, const std::vector<std::string>& more, int machines = 1) const {
    std::vector<Blocks> all;
    for (int frame = 0; frame < frames; ++frame) {
      std::vector<std::string> words{
          "render",      path("turn.json"),
          "-o",          path("a.exr"),
          "--frame",     fmt::format("{}", frame),
          "--seed",      fmt::format("{}", seed(100 * stream + static_cast<std::uint64_t>(frame))),
          "--threads",   "2",
          "--layers",    "beauty",
          "--precision", "float",
          "--quiet"};
      for (std::string word : more) {
        if (word.ends_with(".cache")) word = path(fmt::format("{}{}", frame * machines / frames, word));
        words.push_back(word);
      }
      const Outcome outcome = run(words);
      EXPECT_EQ(outcome.status, 0) << outcome.err;
      const auto picture = image::read_exr(path("a.exr"));
      EXPECT_TRUE(picture);
      if (!picture) return {};
      all.push_back(blocks_of(*picture));
    }
    return all;
  }
};

/// Seeds 100 to 705. The variance over the frames is held to that of a render by `exact`, which has noise alone; both
/// are relative to another one by `exact`. That the test can see flicker is shown by frames of which every second one
/// is 15 % brighter.
TEST_F(Flicker, ALearnedTurntableDiffersFromATracedOneByNoiseOnly) {
  const std::vector<std::string> exact{"--model", "elliptical", "--estimator", "exact"},
      carried{"--warm-cache", "carried.cache"};
  const std::vector<Blocks> reference = render(1, exact), traced = render(2, exact);
  ASSERT_EQ(reference.size() + traced.size(), 2u * frames);
  const Moves noise(traced, reference);
  const auto z_of = [&](const std::vector<Blocks>& way) {
    const Moves moves(way, reference);
    return std::log(moves.sum / noise.sum) / std::sqrt(2 / moves.degrees() + 2 / noise.degrees());
  };
  const auto expect_still = [&](const char* name, const std::vector<Blocks>& way) {
    ASSERT_EQ(way.size(), static_cast<std::size_t>(frames));
    RecordProperty(name, std::to_string(z_of(way)));
    EXPECT_LT(z_of(way), z_limit) << name;
  };
  expect_still("cold", render(3, {}));
  expect_still("carried", render(4, carried));
  expect_still("frozen", render(5, {"--warm-cache", "carried.cache", "--cache-mode", "frozen"}));
  expect_still("two_machines", render(6, {"--warm-cache", "machine.cache"}, 2));
  std::vector<Blocks> flickering = traced;
  for (std::size_t f = 0; f < frames; f += 2)
    for (double& block : flickering[f]) block *= 1.15;
  EXPECT_GT(z_of(flickering), z_limit);
}

}  // namespace
}  // namespace tress::test
