// Textures of meshes: bilinear values by hand, repeats, and what is reported of a scene that has one.
#include "scene/model/texture.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "image/picture.h"
#include "scene/read/input_files.h"
#include "scene/read/load_scene.h"

namespace tress::scene {
namespace {

namespace fs = std::filesystem;

// 2 x 2, top row first: red, green; blue, white.
const std::vector<glm::vec3> four{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};

void expect_near(const glm::vec3& a, const glm::vec3& b) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], 1e-3) << c;
}

TEST(Texture, IsBilinearBetweenTheMiddlesOfPixelsWithVUpwards) {
  const Texture texture(2, 2, four);
  expect_near(texture.at({0.25f, 0.75f}), four[0]);
  expect_near(texture.at({0.75f, 0.75f}), four[1]);
  expect_near(texture.at({0.25f, 0.25f}), four[2]);
  expect_near(texture.at({0.75f, 0.25f}), four[3]);
  expect_near(texture.at({0.375f, 0.75f}), {0.75f, 0.25f, 0});
  expect_near(texture.at({0.5f, 0.5f}), {0.5f, 0.5f, 0.5f});
  expect_near(texture.mean(), {0.5f, 0.5f, 0.5f});
}

TEST(Texture, IsRepeatedAndContinuousThere) {
  const Texture texture(2, 2, four);
  for (const float shift : {-3.0f, 1.0f, 7.0f}) {
    expect_near(texture.at({0.3f + shift, 0.6f}), texture.at({0.3f, 0.6f}));
    expect_near(texture.at({0.3f, 0.6f - shift}), texture.at({0.3f, 0.6f}));
  }
  expect_near(texture.at({0, 0.75f}), {0.5f, 0.5f, 0});
  expect_near(texture.at({1, 0.75f}), texture.at({0, 0.75f}));
  expect_near(texture.at({1e6f, -1e6f}), texture.at({0, 0}));
  expect_near(texture.at({0.9999999f, 1}), texture.at({0, 0}));
}

TEST(Texture, TilesLieSideBySideByTheirNumbers) {
  const Texture tiles(std::map<int, Texture>{
      {1001, Texture(1, 1, {{1, 0, 0}})}, {1002, Texture(1, 1, {{0, 1, 0}})}, {1011, Texture(2, 2, four)}});
  expect_near(tiles.at({0.5f, 0.5f}), {1, 0, 0});
  expect_near(tiles.at({1.01f, 0.99f}), {0, 1, 0});
  expect_near(tiles.at({0.25f, 1.75f}), four[0]);
  expect_near(tiles.at({2.5f, 0.5f}), tiles.mean());
  expect_near(tiles.mean(), {0.5f, 0.5f, 0.5f / 3});
  EXPECT_TRUE(tiles.is_at({1.5f, 0.5f}));
  for (const glm::vec2 uv : {glm::vec2(2.5f, 0.5f), glm::vec2(-0.1f, 0.5f), glm::vec2(10.5f, 0)})
    EXPECT_FALSE(tiles.is_at(uv));
  EXPECT_EQ(udim_tile({9.5f, 99.5f}), 0) << "2000";
  EXPECT_EQ(udim_tile({8.5f, 99.5f}), 1999);
  EXPECT_TRUE(Texture(2, 2, four).is_at({7, -3}));
}

TEST(Texture, OneOfOnePixelIsItsColor) {
  const Texture texture(1, 1, {{0.25f, 0.5f, 0.75f}});
  for (const float x : {-0.7f, 0.0f, 0.5f, 1.0f}) expect_near(texture.at({x, 2 * x}), {0.25f, 0.5f, 0.75f});
}

class TexturedMesh : public ::testing::Test {
 protected:
  TexturedMesh() : folder_(fs::path(testing::TempDir()) / fmt::format("tress_texture_{}", getpid())) {
    fs::create_directories(folder_);
    write("uv.obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1 0\nf 1/1 2/2 3/3\n");
    write("plain.obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n");
    image::Picture picture;
    picture.width = picture.height = 1;
    for (const char* name : {"R", "G", "B"}) picture.channels.push_back({name, {name[0] == 'R' ? 1.5f : 0.25f}});
    EXPECT_FALSE(image::write_exr(folder_ / "color.exr", picture));
  }
  ~TexturedMesh() override { fs::remove_all(folder_); }

  void write(const std::string& name, const std::string& text) const { std::ofstream(folder_ / name) << text; }

  Result<Scene> load(const std::string& mesh) const {
    write("scene.json", "{\"grooms\": [{\"generate\": \"single_fiber\"}], \"meshes\": [" + mesh + "]}");
    return load_scene(folder_ / "scene.json");
  }

  std::string refusal(const std::string& mesh) const {
    const auto scene = load(mesh);
    return scene ? "" : scene.error().message();
  }

  fs::path folder_;
};

TEST_F(TexturedMesh, HasItsUvsItsTextureAndItsCoat) {
  const auto scene =
      load(R"({"file": "uv.obj", "albedo_file": "color.exr", "coat": {"roughness": 0.4, "eta": 1.4}, "name": "skin"})");
  ASSERT_TRUE(scene) << scene.error().message();
  const Mesh& mesh = scene->meshes.at(0);
  ASSERT_TRUE(mesh.texture);
  EXPECT_EQ(mesh.texture->at({0.3f, 0.3f}), glm::vec3(1, 0.25f, 0.25f));
  ASSERT_EQ(scene->warnings.size(), 1u);
  EXPECT_NE(scene->warnings[0].find("1 of 3 values"), std::string::npos) << scene->warnings[0];
  EXPECT_EQ(mesh.corner_uvs.at(0), glm::uvec3(0, 1, 2));
  EXPECT_EQ(mesh.uvs.at(1), glm::vec2(1, 0));
  EXPECT_EQ(mesh.object, "skin");
  ASSERT_TRUE(mesh.coat);
  EXPECT_FLOAT_EQ(mesh.coat->roughness, 0.4f);
  EXPECT_FLOAT_EQ(mesh.coat->eta, 1.4f);
}

TEST_F(TexturedMesh, ReportsWhatIsWrong) {
  EXPECT_NE(
      refusal(R"({"file": "plain.obj", "albedo_file": "color.exr"})").find("expected faces with texture coordinates"),
      std::string::npos);
  EXPECT_NE(refusal(R"({"file": "uv.obj", "albedo_file": "gone.png"})").find("gone.png"), std::string::npos);
  EXPECT_NE(refusal(R"({"file": "uv.obj", "albedo_file": "plain.obj"})").find("expected a PNG or EXR picture"),
            std::string::npos);
  EXPECT_NE(refusal(R"({"file": "uv.obj", "albedo_file": "color.exr", "albedo": [1, 1, 1]})").find("albedo"),
            std::string::npos);
  EXPECT_NE(refusal(R"({"file": "uv.obj", "coat": {"roughness": 0}})").find("coat/roughness"), std::string::npos);
  EXPECT_NE(refusal(R"({"file": "uv.obj", "coat": {"gloss": 1}})").find("gloss"), std::string::npos);
}

// Names of objects: as they are given, else by file or kind, a number behind where another has it.
TEST_F(TexturedMesh, ObjectsHaveNamesOfTheirOwnUnlessTheyAreGiven) {
  write("scene.json", R"({"meshes": [{"file": "plain.obj"}, {"file": "plain.obj"}, {"file": "uv.obj", "name": "plain"}],
      "grooms": [{"generate": "single_fiber"}, {"generate": "single_fiber"}, {"generate": "single_fiber", "name": "x"}]})");
  const auto scene = load_scene(folder_ / "scene.json");
  ASSERT_TRUE(scene) << scene.error().message();
  std::vector<std::string> names;
  for (const Mesh& mesh : scene->meshes) names.push_back(mesh.object);
  for (const Groom& groom : scene->grooms) names.push_back(groom.object);
  EXPECT_EQ(names, (std::vector<std::string>{"plain", "plain 2", "plain", "single_fiber", "single_fiber 2", "x"}));
}

// The frame after this one is known where a scene moves, also at the last key, where the camera rests.
TEST_F(TexturedMesh, AMovingSceneKnowsItsNextFrame) {
  write("scene.json", R"({"grooms": [{"generate": "single_fiber"}],
      "camera": {"frames": [{"frame": 10, "eye": [0, -30, 0]}, {"frame": 12, "eye": [4, -30, 0]}]}})");
  const auto first = load_scene(folder_ / "scene.json");
  ASSERT_TRUE(first) << first.error().message();
  ASSERT_TRUE(first->next);
  EXPECT_EQ(first->camera.eye, glm::vec3(0, -30, 0));
  EXPECT_EQ(first->next->camera.eye, glm::vec3(2, -30, 0));
  Overrides last;
  last.frame = 12;
  const auto end = load_scene(folder_ / "scene.json", last);
  ASSERT_TRUE(end && end->next);
  EXPECT_EQ(end->next->camera.eye, end->camera.eye);
  EXPECT_FALSE(load(R"({"file": "uv.obj"})")->next);
}

}  // namespace
}  // namespace tress::scene
