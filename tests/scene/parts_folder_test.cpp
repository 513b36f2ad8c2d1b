// A folder of parts is a scene: each its material, one unit and one axis for all.
#include "scene/read/parts_folder.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "scene/model/hair_colors.h"

namespace tress::scene {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class PartsFolder : public ::testing::Test {
 protected:
  void SetUp() override { fs::create_directories(folder_ / "below"); }
  void TearDown() override { fs::remove_all(folder_); }
  void put_groom(const std::string& from, const std::string& name) const {
    fs::copy_file(fs::path(TRESS_SOURCE_DIR) / "tests" / "scene" / "grooms" / from, folder_ / name);
  }
  void write(const std::string& name, const std::string& text) const { std::ofstream(folder_ / name) << text; }

  const fs::path folder_ = fs::path(testing::TempDir()) / ("tress_parts_" + std::to_string(getpid()));
};

TEST_F(PartsFolder, EveryPartIsThereWithItsMaterialUnitAndAxis) {
  put_groom("same.hair", "beard.hair");
  put_groom("same.abc", "brows.abc");
  put_groom("same.usda", "crown.usda");
  write("head.obj", "v 0 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\n");
  write("notes.txt", "not a groom");
  write("below/other.hair", "not looked at");
  write("materials.json", R"([{"name": "grown", "hair": "red"}, {"name": "beard", "hair": "black"}])");
  const auto scene = load_scene(folder_);
  ASSERT_TRUE(scene) << scene.error().message();
  ASSERT_EQ(scene->grooms.size(), 3u);
  EXPECT_EQ(scene->grooms[0].object, "beard");
  EXPECT_EQ(scene->grooms[1].object, "brows");
  EXPECT_EQ(scene->materials[scene->grooms[0].material].fiber.sigma_a, *AbsorptionOf(false).hair("black"));
  EXPECT_EQ(scene->materials[scene->grooms[1].material].name, "grown");
  ASSERT_EQ(scene->meshes.size(), 1u);
  EXPECT_EQ(scene->meshes[0].positions[2], glm::vec3(0, 2, 0));
  EXPECT_EQ(scene->grooms[0].points[9], scene->grooms[2].points[9]);  // .hair says no unit, .usda says centimetres
  Overrides overrides;
  overrides.cm_per_unit = 2;
  overrides.y_up = true;
  const auto turned = load_scene(folder_, overrides);
  ASSERT_TRUE(turned) << turned.error().message();
  const glm::vec3 p = scene->grooms[0].points[9];
  EXPECT_EQ(turned->grooms[0].points[9], glm::vec3(2 * p.x, -2 * p.z, 2 * p.y));
  EXPECT_EQ(turned->meshes[0].positions[2], glm::vec3(0, 0, 4));
}

TEST_F(PartsFolder, ASceneInItIsWhatIsDrawn) {
  put_groom("same.hair", "beard.hair");
  put_groom("same.hair", "hidden.hair");
  write("scene.json", R"({"grooms": [{"file": "beard.hair"}]})");
  const auto scene = load_scene(folder_);
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_EQ(scene->grooms.size(), 1u);
}

TEST_F(PartsFolder, WhatIsWrongIsSaidByTheFileThatHasIt) {
  EXPECT_THAT(load_scene(folder_).error().message(), HasSubstr("scene.json or grooms (.hair"));
  put_groom("same.hair", "beard.hair");
  write("materials.json", R"([{"name": "beard", "rougness": 0.3}])");
  EXPECT_THAT(load_scene(folder_).error().message(), HasSubstr("materials.json: /materials/0"));
  write("materials.json", "[{");
  EXPECT_THAT(load_scene(folder_).error().message(), HasSubstr("materials.json: byte"));
  write("materials.json", "{}");
  EXPECT_THAT(load_scene(folder_).error().message(), HasSubstr("materials.json: /materials"));
  fs::remove(folder_ / "materials.json");
  put_groom("malformed/cut.usda", "cut.usda");
  EXPECT_THAT(load_scene(folder_).error().message(), HasSubstr("cut.usda: line"));
}

}  // namespace
}  // namespace tress::scene
