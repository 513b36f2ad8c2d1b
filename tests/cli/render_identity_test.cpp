// What distinguishes a render: values of the scene as they are, and the content of the files that it names.
#include "cli/render_identity.h"

#include <gtest/gtest.h>

#include "cli/run_tress.h"

namespace tress::test {
namespace {

class RenderIdentity : public CommandTest {
 protected:
  cli::Identity of_scene(const std::string& text) const {
    write_text(path("scene.json"), text);
    return cli::identity_of(path("scene.json"), {});
  }
};

TEST_F(RenderIdentity, HasTheContentOfWhatTheSceneReads) {
  const std::string scene =
      R"({"environment": {"file": "city.exr"}, "meshes": [{"file": "m.obj", "albedo_file": "a.png"}],
          "materials": [{"name": "m", "color": {"mix": [[0.1, 0.1, 0.1], {"texture": "t.png"}], "share": 0.5}}],
          "grooms": [{"file": "g.hair"}]})";
  for (const char* name : {"city.exr", "m.obj", "a.png", "g.hair", "t.png"}) write_text(path(name), "first");
  const cli::Identity before = of_scene(scene);
  for (const char* name : {"city.exr", "m.obj", "a.png", "g.hair", "t.png"}) write_text(path(name), "second");
  const cli::Identity after = of_scene(scene);
  for (const char* place : {"/environment/file", "/meshes/0/file", "/meshes/0/albedo_file",
                            "/materials/0/color/mix/1/texture", "/grooms/0/file"})
    EXPECT_NE(before.at(place), after.at(place)) << place;
}

TEST_F(RenderIdentity, HasTheContentOfEveryTileOfATexture) {
  const std::string scene = R"({"materials": [{"name": "m", "color": {"texture": "t.<UDIM>.png"}}]})",
                    place = "/materials/0/color/texture";
  write_text(path("t.1001.png"), "first");
  const std::string one = of_scene(scene).at(place);
  write_text(path("t.1012.png"), "first");
  const std::string two = of_scene(scene).at(place);
  write_text(path("t.1012.png"), "second");
  EXPECT_NE(one, two);
  EXPECT_NE(two, of_scene(scene).at(place));
}

/// Values of the file, of --set and of the options that it has replaced are one, whichever gave them.
TEST_F(RenderIdentity, IsOfValuesHoweverTheyWereGiven) {
  const std::string grooms = R"("grooms": [{"generate": "single_fiber"}])";
  const cli::Identity in_file =
      of_scene(R"({"image": {"exposure": 1}, "integrator": {"max_depth": 8, "near": 2}, )" + grooms + "}");
  of_scene("{" + grooms + "}");
  const std::vector<std::string> settings{"image/exposure=1.0", "integrator/max_depth=8", "integrator/near=2.0"};
  EXPECT_EQ(cli::identity_of(path("scene.json"), {}, settings), in_file);
  const cli::Identity by_options = cli::identity_of(path("scene.json"), {{"--spp", "8"}, {"--resolution", "64x48"}});
  EXPECT_EQ(of_scene(R"({"image": {"width": 64, "height": 48, "samples": 8}, )" + grooms + "}"), by_options);
  write_text(path("bare.hair"), "strands");
  const cli::Identity bare = cli::identity_of(path("bare.hair"), {}, settings);
  EXPECT_EQ(bare.at("/integrator/max_depth"), "8");
  EXPECT_TRUE(bare.contains("scene"));
}

/// A text that happens to be the name of a file beside the scene is that text: parts whose folders hold other files of
/// that name are of one picture.
TEST_F(RenderIdentity, TakesOtherTextsForWhatTheyAre) {
  write_text(path("brown"), "a file that nobody reads");
  const cli::Identity identity = of_scene(R"({"materials": [{"name": "brown"}], "grooms": [{"file": "brown"}]})");
  EXPECT_EQ(identity.at("/materials/0/name"), "brown");
  EXPECT_NE(identity.at("/grooms/0/file"), "brown");
}

}  // namespace
}  // namespace tress::test
