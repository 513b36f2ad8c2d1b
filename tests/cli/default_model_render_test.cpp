// Which model a command without --model takes: that of the scene's materials, whatever is asked of its accuracy.
#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "cli/run_tress.h"
#include "image/picture.h"

namespace tress::test {
namespace {

using ::testing::AllOf;
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
    write_text(path("marrow.json"), scene_with(R"(, "azimuthal_sigma_deg": {"TT": 12}, "medulla": {"radius": 0.5})"));
    write_text(path("wet.json"),
               scene_with(R"(, "azimuthal_sigma_deg": {"TT": 12}, "cortex": {"scattering": 1}, "wetness": 1)"));
  }
  static std::string scene_with(const std::string& keys) {
    return R"({"camera": {"frame": true}, "image": {"width": 16, "height": 16, "samples": 8},
      "environment": {"constant": [1, 1, 1]}, "materials": [{"name": "hair")" +
           keys + R"(}], "grooms": [{"generate": "straight", "strands": 300, "radius_cm": 0.04, "material": "hair"}]})";
  }
  /// What it was rendered by, by the picture's header; the note on stderr, if there is one, goes to `notes`.
  std::string model_of(const std::string& scene, const std::vector<std::string>& more) {
    std::vector<std::string> command{"render", path(scene), "-o", path("a.exr")};
    command.insert(command.end(), more.begin(), more.end());
    const Outcome outcome = run(command);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    notes = outcome.err;
    const auto picture = image::read_exr(path("a.exr"));
    return picture ? picture->metadata.at("model") : "no picture";
  }
  /// Of a command that is refused with exit status 2 and writes nothing, what it says.
  std::string refusal(const std::string& scene, const std::vector<std::string>& more) {
    std::vector<std::string> command{"render", path(scene), "-o", path("refused.exr")};
    command.insert(command.end(), more.begin(), more.end());
    const Outcome outcome = run(command);
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_FALSE(fs::exists(path("refused.exr")));
    return outcome.err;
  }
  std::string notes;
};

TEST_F(DefaultModel, IsRough) {
  EXPECT_EQ(model_of("scene.json", {}), "rough");
  EXPECT_THAT(notes, Not(HasSubstr("model ")));
}

/// One by one: each of these chose another model once.
TEST_F(DefaultModel, IsNotChangedByAnOptionOfAccuracy) {
  for (const std::vector<std::string>& option : {std::vector<std::string>{"--epsilon", "0.3"},
                                                 {"--estimator", "fitted"},
                                                 {"--estimator", "exact"},
                                                 {"--picture-error", "0.3"},
                                                 {"--table-memory", "100"},
                                                 {"--measure-bias", "0.1"},
                                                 {"--warm-cache", path("w.cache")},
                                                 {"--warm-cache", path("w.cache"), "--cache-mode", "frozen"},
                                                 {"--warm-cache", path("w.cache"), "--cache-mode", "require"},
                                                 {"--warm-cache", path("w.cache"), "--cache-mode", "scratch"}}) {
    EXPECT_EQ(model_of("scene.json", option), "rough") << option[0] << " " << option[1];
    EXPECT_THAT(notes, Not(HasSubstr("elliptical")));
  }
  EXPECT_EQ(model_of("scene.json", {"--model", "exact"}), "elliptical") << "named";
  EXPECT_EQ(model_of("scene.json", {"--model", "elliptical", "--epsilon", "0.02"}), "elliptical") << "named";
}

TEST_F(DefaultModel, HoldsRowsOfSamplesToTheEpsilonThatWasAsked) {
  EXPECT_EQ(model_of("scene.json", {"--epsilon", "0.3", "--telemetry", path("e.jsonl")}), "rough");
  const nlohmann::json header = telemetry_lines(path("e.jsonl"), "header").at(0);
  EXPECT_EQ(header.at("model"), "rough");
  EXPECT_EQ(header.at("epsilon"), 0.3);
}

/// With an exit status of 2 and the models that have it, not by rendering another model.
TEST_F(DefaultModel, RefusesAnOptionThatItHasNot) {
  EXPECT_THAT(refusal("scene.json", {"--estimator", "corrected"}),
              AllOf(HasSubstr("--estimator corrected: expected "), HasSubstr("(elliptical)"),
                    HasSubstr("found rough, the model of the scene's materials: add --model elliptical")));
  for (const std::vector<std::string>& option :
       {std::vector<std::string>{"--learner", "sketch"}, {"--components", "4"}})
    EXPECT_THAT(refusal("scene.json", option),
                AllOf(HasSubstr(option[0] + ": expected a model whose rows a learner fits (elliptical)"),
                      HasSubstr("found rough, the model of the scene's materials: add --model elliptical")));
  for (const std::vector<std::string>& option : {std::vector<std::string>{"--epsilon", "0.02"},
                                                 {"--picture-error", "0.1"},
                                                 {"--table-memory", "100"},
                                                 {"--measure-bias", "0.1"},
                                                 {"--estimator", "exact"}})
    EXPECT_THAT(refusal("principled.json", option),
                AllOf(HasSubstr(option[0] + ": expected a model with rows (elliptical, rough"),
                      HasSubstr("found chiang2016, the model of the scene's materials: add --model elliptical")));
  EXPECT_EQ(model_of("shaped.json", {"--estimator", "corrected", "--epsilon", "0.02"}), "elliptical")
      << "its model has both";
  const Outcome baked = run({"cache", "prebake", path("scene.json"), "-o", path("b.cache"), "--learner", "sketch"});
  EXPECT_EQ(baked.status, 2) << baked.err;
  EXPECT_THAT(baked.err, HasSubstr("--learner: expected a model whose rows a learner fits (elliptical)"));
}

TEST_F(DefaultModel, IsEllipticalWhereAMaterialShapesLobes) {
  for (const char* scene : {"shaped.json", "fitted.json"}) {
    EXPECT_EQ(model_of(scene, {}), "elliptical") << scene;
    EXPECT_THAT(notes, HasSubstr("model elliptical: a material shapes its lobes"));
    EXPECT_EQ(model_of(scene, {"--model", "rough"}), "rough") << scene;
  }
}

TEST_F(DefaultModel, WarnsOfAMedullaThatTheModelHasNot) {
  constexpr const char* warning =
      "material hair: medulla: left out by model elliptical, whose fibers have none; models "
      "that have it: rough, fiber3d";
  EXPECT_EQ(model_of("marrow.json", {}), "elliptical");
  EXPECT_THAT(notes, HasSubstr(warning));
  EXPECT_EQ(model_of("marrow.json", {"--model", "rough"}), "rough");
  EXPECT_THAT(notes, Not(HasSubstr("left out")));
  model_of("wet.json", {});
  for (const char* part : {"cortex", "wetness"})
    EXPECT_THAT(notes, HasSubstr(std::string("material hair: ") + part + ": left out by model elliptical"));
}

/// As where it comes from: by the lobes that the node has (scenes/blender/README.md).
TEST_F(DefaultModel, OfPrincipledHairIsTheNodesOwn) {
  for (const char* scene : {"principled.json", "published.json", "node.json"}) {
    EXPECT_EQ(model_of(scene, {}), "chiang2016") << scene;
    EXPECT_THAT(notes, HasSubstr("model chiang2016: its hair is given by the lobes of that")) << scene;
  }
  EXPECT_EQ(model_of("flat.json", {}), "rough") << "no fiber of that node";
  EXPECT_EQ(model_of("principled.json", {"--model", "elliptical"}), "elliptical");
}

TEST_F(DefaultModel, OfPrincipledHairLeavesACacheAlone) {
  EXPECT_EQ(model_of("principled.json", {"--warm-cache", path("p.cache")}), "chiang2016");
  EXPECT_THAT(notes, HasSubstr("p.cache: not used and left as it is, model chiang2016 has no rows"));
  EXPECT_FALSE(fs::exists(path("p.cache")));
  const Outcome baked = run({"cache", "prebake", path("principled.json"), "-o", path("baked.cache")});
  EXPECT_EQ(baked.status, 2) << baked.err;
  EXPECT_THAT(baked.err, AllOf(HasSubstr("cache prebake: expected a model with rows (elliptical, rough"),
                               HasSubstr("found chiang2016, the model of the scene's materials")));
  EXPECT_FALSE(fs::exists(path("baked.cache")));
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

/// The rows stay in the file, and those of the scene's model are learned into it.
TEST_F(DefaultModel, IsNotThatOfTheRowsInTheWarmCache) {
  const auto rows_of = [&](const char* kind) {
    const auto info = nlohmann::json::parse(run({"cache", "info", path("t.cache"), "--json"}).out);
    int rows = 0;
    for (const auto& page : info.at("pages"))
      if (page.at("kind") == kind)
        rows += page.at("rows").at("open").get<int>() + page.at("rows").at("converged").get<int>();
    return rows;
  };
  EXPECT_EQ(model_of("scene.json", {"--model", "elliptical", "--warm-cache", path("t.cache")}), "elliptical");
  const int before = rows_of("densities");
  EXPECT_GT(before, 0);
  EXPECT_EQ(rows_of("samples"), 0);
  EXPECT_EQ(model_of("scene.json", {"--warm-cache", path("t.cache")}), "rough");
  EXPECT_THAT(notes, Not(HasSubstr("refused")));
  EXPECT_EQ(rows_of("densities"), before) << "kept";
  EXPECT_GT(rows_of("samples"), 0) << "learned into";
  write_text(path("broken.cache"), "no cache");
  EXPECT_EQ(model_of("scene.json", {"--warm-cache", path("broken.cache")}), "rough") << "refused, and reported";
}

/// The fur that lost its medulla to any of these options: its mean fell from 0.235 to 0.164.
TEST_F(DefaultModel, KeepsTheMedullaOfFurUnderOptionsOfAccuracy) {
  const auto mean = [&](const std::vector<std::string>& more) {
    std::vector<std::string> command{"render",       std::string(TRESS_SOURCE_DIR) + "/scenes/fur_medulla.json",
                                     "-o",           path("fur.exr"),
                                     "--spp",        "16",
                                     "--resolution", "32x32",
                                     "--quiet"};
    command.insert(command.end(), more.begin(), more.end());
    const Outcome outcome = run(command);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    const auto picture = image::read_exr(path("fur.exr"));
    if (!picture) return 0.0;
    EXPECT_EQ(picture->metadata.at("model"), more.size() > 1 && more[1] == "elliptical" ? "elliptical" : "rough");
    double sum = 0, count = 0;
    for (const char* name : {"R", "G", "B"})
      for (const float x : picture->find(name)->pixels) sum += double{x}, count += 1;
    return sum / count;
  };
  const double usual = mean({}), without = mean({"--model", "elliptical"});
  // One seed each; what the options change of the fits and of the noise is well within a quarter of what a medulla
  // does.
  const double allowed = 0.25 * (usual - without);
  EXPECT_GT(allowed, 0.005) << "too little to show";
  for (const std::vector<std::string>& option : {std::vector<std::string>{"--epsilon", "0.1"},
                                                 {"--estimator", "exact"},
                                                 {"--picture-error", "0.1"},
                                                 {"--table-memory", "64"}}) {
    const double found = mean(option);
    EXPECT_NEAR(found, usual, allowed) << option[0];
    std::printf("%s %s: %.4f, usual %.4f, elliptical %.4f\n", option[0].c_str(), option[1].c_str(), found, usual,
                without);
  }
}

}  // namespace
}  // namespace tress::test
