// tress render --deep-light learned: what it reports, what it refuses, and parts of such a picture.
#include <gmock/gmock.h>

#include <filesystem>
#include <string>
#include <vector>

#include "cli/run_tress.h"
#include "image/picture.h"

namespace tress::test {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

class DeepLight : public CommandTest {
 protected:
  void write_scene(const std::string& light) const {
    write_text(path("scene.json"), R"({
      "camera": {"frame": true},
      "image": {"width": 48, "height": 48, "samples": 24},
      "environment": {"constant": [1, 0.9, 0.8]},
      "lights": [{"sphere": {"center": [20, 0, 20], "radius_cm": 5, "radiance": [9, 9, 9]})" +
                                       light + R"(}],
      "materials": [{"name": "blond", "sigma_a": [0.02, 0.04, 0.1]}],
      "grooms": [{"generate": "curly", "strands": 800, "radius_cm": 0.04, "material": "blond"}]
    })");
  }
  Outcome rendered(const std::string& name, const std::vector<std::string>& more) const {
    std::vector<std::string> words{"render",     path("scene.json"), "-o", path(name + ".exr"), "--model",
                                   "elliptical", "--threads",        "2",  "--telemetry",       path(name + ".jsonl")};
    words.insert(words.end(), more.begin(), more.end());
    return run(words);
  }
};

TEST_F(DeepLight, ReportsItsBiasAndMergesIt) {
  write_scene("");
  const std::vector<std::string> learned{"--deep-light", "learned", "--deep-light-depth", "2"};
  const auto with = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = learned;
    words.insert(words.end(), more.begin(), more.end());
    return words;
  };
  const Outcome whole = rendered("whole", learned);
  ASSERT_EQ(whole.status, 0) << whole.err;
  EXPECT_THAT(whole.err, HasSubstr("light from deep in the hair is learned"));
  const auto picture = image::read_exr(path("whole.exr"));
  ASSERT_TRUE(picture && picture->metadata.contains("deep_light_bias"));
  EXPECT_THAT(picture->metadata.at("deep_light_bias"), HasSubstr(" +- "));
  const auto bias = telemetry_lines(path("whole.jsonl"), "summary").back().at("deep_light_bias");
  EXPECT_GT(bias.at("paths").get<int>(), 100);
  EXPECT_GT(bias.at("error").get<double>(), 0);
  ASSERT_EQ(rendered("a", with({"--samples-to", "12", "--part", path("a.part")})).status, 0);
  ASSERT_EQ(rendered("b", with({"--samples-from", "12", "--part", path("b.part")})).status, 0);
  const Outcome merged = run({"merge", path("a.part"), path("b.part"), "-o", path("merged.exr")});
  ASSERT_EQ(merged.status, 0) << merged.err;
  const auto all = image::read_exr(path("merged.exr"));
  ASSERT_TRUE(all);
  EXPECT_TRUE(all->metadata.contains("deep_light_bias"));
  const Outcome traced = rendered("traced", {});
  ASSERT_EQ(traced.status, 0) << traced.err;
  EXPECT_FALSE(image::read_exr(path("traced.exr"))->metadata.contains("deep_light_bias"));
}

TEST_F(DeepLight, RefusesByNameWhatCannotBeAnswered) {
  write_scene(R"(, "group": "key")");
  const Outcome groups = rendered("groups", {"--deep-light", "learned"});
  EXPECT_EQ(groups.status, 2);
  EXPECT_THAT(groups.err, HasSubstr("/integrator/deep_light: expected traced in a scene whose lights have a `group`"));
  EXPECT_FALSE(fs::exists(path("groups.exr")));
  write_scene("");
  const Outcome rule = rendered("rule", {"--deep-light", "learned", "--roulette", "throughput"});
  EXPECT_EQ(rule.status, 1);
  EXPECT_THAT(rule.err, HasSubstr("/integrator/deep_light: expected traced with roulette throughput"));
  EXPECT_EQ(rendered("depth", {"--deep-light", "learned", "--deep-light-depth", "1"}).status, 2);
  EXPECT_EQ(rendered("alone", {"--deep-light-depth", "3"}).status, 1);
}

}  // namespace
}  // namespace tress::test
