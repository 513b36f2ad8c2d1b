#include "scene/scene_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "scene/generated_grooms.h"
#include "scene/scene.h"

namespace tress::scene {
namespace {

std::string message(const std::string& text) {
  const std::vector<unsigned char> bytes(text.begin(), text.end());
  const auto scene = parse_scene_file(bytes, "s.json");
  return scene ? "" : scene.error().message();
}

const std::string groom = R"("grooms": [{"generate": "single_fiber"}])";

TEST(SceneFile, NamesThePathAndTheExpectation) {
  EXPECT_EQ(message("{" + groom + "}"), "");
  EXPECT_EQ(message(R"({"materials": [{"eccentricity": 3}], )" + groom + "}"),
            "s.json: /materials/0/eccentricity: expected 0.5..1, found 3");
  EXPECT_NE(message(R"({"materials": [{"rougness": 0.3}], )" + groom + "}").find("nearest is \"roughness\""),
            std::string::npos);
  const std::pair<std::string, std::string> wrong[] = {
      {R"({)", "byte"},
      {"", "byte"},
      {"[]", "s.json: /: expected an object"},
      {R"({"grooms": []})", "/grooms"},
      {R"({"grooms": [{"generate": "afro"}]})", "/grooms/0/generate"},
      {R"({"grooms": [{"generate": "straight", "strands": 1e12}]})", "/grooms/0/strands"},
      {R"({"grooms": [{"generate": "straight", "strands": -1}]})", "/grooms/0/strands"},
      {R"({"grooms": [{"generate": "straight", "length_cm": 1e999}]})", "s.json"},
      {R"({"grooms": [{"generate": "straight", "file": "a.hair"}]})", "/grooms/0"},
      {R"({"grooms": [{"generate": "straight", "material": "x"}]})", "/grooms/0/material"},
      {R"({"image": {"width": 0}, )" + groom + "}", "/image/width"},
      {R"({"image": {"width": 65536, "height": 65536}, )" + groom + "}", "/image"},
      {R"({"camera": {"eye": [0, 0, null]}, )" + groom + "}", "/camera/eye/2"},
      {R"({"camera": {"eye": [0, 0, 1], "look_at": [0, 0, 0]}, )" + groom + "}", "/camera/up"},
      {R"({"environment": {"constant": [-1, 0, 0]}, )" + groom + "}", "/environment/constant/0"},
      {R"({"materials": [{"color": [1, 1, 1]}], )" + groom + "}", "/materials/0/color/0"},
      {R"({"materials": [{"longitudinal_lambda_deg": {"R": 0}}], )" + groom + "}",
       "/materials/0/longitudinal_lambda_deg/R"}};
  for (const auto& [text, place] : wrong) EXPECT_NE(message(text).find(place), std::string::npos) << message(text);
}

TEST(SceneFile, SurvivesDeepNestingAndEveryTruncation) {
  EXPECT_NE(message(std::string(100000, '[')), "");
  const std::string whole = R"({"camera": {"frame": true}, "materials": [{"name": "a", "eta": 1.5}], )" + groom + "}";
  for (std::size_t size = 0; size < whole.size(); ++size) EXPECT_NE(message(whole.substr(0, size)), "") << size;
}

TEST(LoadScene, RefusesMissingEmptyAndFolders) {
  const auto folder = std::filesystem::path(testing::TempDir());
  const auto empty = folder / "tress_empty.hair";
  std::ofstream(empty).close();
  EXPECT_NE(load_scene(folder / "tress_missing.json").error().message().find("no such file"), std::string::npos);
  EXPECT_NE(load_scene(empty).error().message().find("an empty file"), std::string::npos);
  EXPECT_NE(load_scene(folder).error().message().find("a directory"), std::string::npos);
  std::filesystem::remove(empty);
}

TEST(LoadScene, LoadsTheScenesOfTheProject) {
  for (const char* name : {"demo.json", "curly_lock.json", "straight_groom.json", "furnace.json"}) {
    const auto scene = load_scene(std::filesystem::path(TRESS_SOURCE_DIR) / "scenes" / name);
    ASSERT_TRUE(scene) << scene.error().message();
    EXPECT_TRUE(scene->warnings.empty());
    for (const auto& p : scene->grooms.at(0).points) ASSERT_TRUE(std::isfinite(p.x + p.y + p.z));
    const float distance = std::hypot(scene->camera.eye.x, scene->camera.eye.y, scene->camera.eye.z);
    EXPECT_GT(distance, 10) << name;
    EXPECT_LT(distance, 300) << name;
  }
}

TEST(GeneratedGrooms, HaveThePapersCountsAndRepeat) {
  const auto curly = generate_groom({.kind = "curly_lock", .strands = {}, .seed = 0, .length_cm = {}});
  EXPECT_EQ(curly.strand_count(), 5513u);
  EXPECT_EQ(generate_groom({.kind = "straight", .strands = {}, .seed = 0, .length_cm = {}}).strand_count(), 19226u);
  EXPECT_EQ(generate_groom({.kind = "curly_lock", .strands = {}, .seed = 0, .length_cm = {}}).points, curly.points);
  EXPECT_NE(generate_groom({.kind = "curly_lock", .strands = {}, .seed = 1, .length_cm = {}}).points, curly.points);
}

TEST(Overrides, ReachTheScene) {
  Overrides overrides;
  overrides.eccentricity = 0.7f;
  overrides.sigma_a = glm::vec3(0.1f, 0.2f, 0.3f);
  overrides.width = 32;
  const auto file = std::filesystem::path(TRESS_SOURCE_DIR) / "scenes" / "furnace.json";
  const auto scene = load_scene(file, overrides);
  ASSERT_TRUE(scene);
  EXPECT_EQ(scene->materials[0].fiber.eccentricity, 0.7f);
  EXPECT_EQ(scene->materials[0].fiber.sigma_a, glm::vec3(0.1f, 0.2f, 0.3f));
  EXPECT_EQ(scene->image.width, 32);
  overrides.eccentricity = 3.0f;
  EXPECT_NE(load_scene(file, overrides).error().message().find("--eccentricity"), std::string::npos);
}

}  // namespace
}  // namespace tress::scene
