// Which model a command without --model takes: `rough`, unless it speaks of `elliptical` in another way.
#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "cli/run_tress.h"
#include "image/picture.h"

namespace tress::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class DefaultModel : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    write_text(path("scene.json"), scene_with(""));
    write_text(path("shaped.json"), scene_with(R"(, "azimuthal_sigma_deg": {"TT": 12})"));
    write_text(path("principled.json"), scene_with(R"(, "principled": {"melanin": 0.5})"));
    write_text(path("published.json"), scene_with(R"(, "principled": {"melanin": 0.5, "widths": "published"})"));
    write_text(path("fitted.json"), scene_with(R"(, "principled": {"melanin": 0.5, "widths": "fitted"})"));
    write_text(path("flat.json"), scene_with(R"(, "principled": {"melanin": 0.5, "aspect_ratio": 0.7})"));
    write_text(path("node.json"), scene_with(R"(, "chiang_hair_bsdf": {"cuticle_angle": 0.51})"));
  }
  static std::string scene_with(const std::string& keys) {
    return R"({"camera": {"frame": true}, "image": {"width": 16, "height": 16, "samples": 8},
      "environment": {"constant": [1, 1, 1]}, "materials": [{"name": "hair")" +
           keys + R"(}], "grooms": [{"generate": "straight", "strands": 300, "radius_cm": 0.04, "material": "hair"}]})";
  }
  /// What it was rendered by, as the picture's header tells; the note on stderr, if there is one, in `told`.
  std::string model_of(const std::string& scene, const std::vector<std::string>& more) {
    std::vector<std::string> command{"render", path(scene), "-o", path("a.exr")};
    command.insert(command.end(), more.begin(), more.end());
    const Outcome outcome = run(command);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    told = outcome.err;
    const auto picture = image::read_exr(path("a.exr"));
    return picture ? picture->metadata.at("model") : "no picture";
  }
  std::string told;
};

TEST_F(DefaultModel, IsRough) {
  EXPECT_EQ(model_of("scene.json", {}), "rough");
  EXPECT_THAT(told, Not(HasSubstr("model ")));
}

TEST_F(DefaultModel, IsEllipticalWhereAnOptionIsOfItsRows) {
  for (const std::vector<std::string>& option : {std::vector<std::string>{"--epsilon", "0.02"},
                                                 {"--learner", "eager"},
                                                 {"--components", "4"},
                                                 {"--estimator", "corrected"}}) {
    EXPECT_EQ(model_of("scene.json", option), "elliptical");
    EXPECT_THAT(told, HasSubstr("model elliptical: " + option[0] + " is of its rows"));
  }
  EXPECT_EQ(model_of("scene.json", {"--model", "exact"}), "elliptical");
  EXPECT_EQ(model_of("scene.json", {"--model", "rough", "--epsilon", "0.5"}), "rough") << "named";
}

TEST_F(DefaultModel, IsEllipticalWhereAMaterialShapesLobes) {
  for (const char* scene : {"shaped.json", "fitted.json"}) {
    EXPECT_EQ(model_of(scene, {}), "elliptical") << scene;
    EXPECT_THAT(told, HasSubstr("model elliptical: a material shapes its lobes"));
    EXPECT_EQ(model_of(scene, {"--model", "rough"}), "rough") << scene;
  }
}

/// As where it comes from: by the lobes that the node has (scenes/blender/README.md).
TEST_F(DefaultModel, OfPrincipledHairIsTheNodesOwn) {
  for (const char* scene : {"principled.json", "published.json", "node.json"}) {
    EXPECT_EQ(model_of(scene, {}), "chiang2016") << scene;
    EXPECT_THAT(told, HasSubstr("model chiang2016: its hair is given by the lobes of that")) << scene;
  }
  EXPECT_EQ(model_of("flat.json", {}), "rough") << "no fiber of that node";
  EXPECT_EQ(model_of("principled.json", {"--model", "elliptical"}), "elliptical");
}

TEST_F(DefaultModel, OfPrincipledHairIsEllipticalWhereRowsAreNeeded) {
  EXPECT_EQ(model_of("principled.json", {"--warm-cache", path("p.cache")}), "elliptical");
  EXPECT_EQ(model_of("principled.json", {"--warm-cache", path("p.cache"), "--cache-mode", "frozen"}), "elliptical");
  EXPECT_EQ(model_of("principled.json", {"--warm-cache", path("p.cache"), "--cache-mode", "scratch"}), "elliptical");
  EXPECT_EQ(model_of("principled.json", {"--table-memory", "100"}), "elliptical");
  EXPECT_EQ(model_of("principled.json", {"--epsilon", "0.02"}), "elliptical");
  const Outcome baked = run({"cache", "prebake", path("principled.json"), "-o", path("baked.cache")});
  EXPECT_EQ(baked.status, 0) << baked.err;
  EXPECT_THAT(baked.err, HasSubstr("model elliptical"));
}

TEST_F(DefaultModel, DrawsPrincipledHairByThePublishedWidths) {
  const auto pixels = [&](const std::string& scene, const std::string& model) {
    EXPECT_EQ(model_of(scene, {"--model", model}), model);
    const auto picture = image::read_exr(path("a.exr"));
    return picture ? picture->find("R")->pixels : std::vector<float>();
  };
  EXPECT_EQ(pixels("principled.json", "chiang2016"), pixels("published.json", "chiang2016"));
  EXPECT_NE(pixels("principled.json", "chiang2016"), pixels("fitted.json", "chiang2016"));
  EXPECT_EQ(pixels("principled.json", "elliptical"), pixels("fitted.json", "elliptical"));
}

TEST_F(DefaultModel, IsThatOfTheRowsInTheWarmCache) {
  const std::vector<std::string> cached{"--warm-cache", path("t.cache")};
  EXPECT_EQ(model_of("scene.json", {"--model", "elliptical", "--warm-cache", path("t.cache")}), "elliptical");
  EXPECT_EQ(model_of("scene.json", cached), "elliptical");
  EXPECT_THAT(told, HasSubstr("t.cache has its rows"));
  EXPECT_EQ(model_of("scene.json", {"--model", "rough", "--warm-cache", path("t.cache")}), "rough");
  EXPECT_EQ(model_of("scene.json", cached), "rough") << "it has rows of both now";
  EXPECT_EQ(model_of("scene.json", {"--model", "elliptical", "--warm-cache", path("e.cache")}), "elliptical");
  EXPECT_EQ(model_of("scene.json", {"--warm-cache", path("e.cache"), "--cache-mode", "scratch"}), "rough")
      << "nothing is read";
  write_text(path("broken.cache"), "no cache");
  EXPECT_EQ(model_of("scene.json", {"--warm-cache", path("broken.cache")}), "rough") << "refused, and told so";
}

}  // namespace
}  // namespace tress::test
