#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <numbers>

#include "scene/generate/generated_grooms.h"
#include "scene/model/camera.h"
#include "scene/read/load_scene.h"
#include "scene/read/scene_file.h"

namespace tress::scene {
namespace {

const std::string groom = R"("grooms": [{"generate": "single_fiber"}])";

Result<SceneDescription> parse(const std::string& camera) {
  const std::string text = R"({"camera": )" + camera + ", " + groom + "}";
  const std::vector<unsigned char> bytes(text.begin(), text.end());
  return parse_scene_file(bytes, "s.json");
}

CameraDescription described(const std::string& camera) {
  const auto scene = parse(camera);
  EXPECT_TRUE(scene) << scene.error().message();
  return scene ? scene->camera : CameraDescription{};
}

Camera at(const CameraDescription& description, std::optional<int> frame) {
  const auto camera = camera_at(description, frame, {}, Image{}, "s.json");
  EXPECT_TRUE(camera) << camera.error().message();
  return camera ? *camera : Camera{};
}

const std::string keys = R"({"frames": [
  {"frame": 10, "eye": [0, -50, 0], "vertical_fov_deg": 20},
  {"frame": 20, "eye": [50, -50, 10], "look_at": [0, 0, 4]},
  {"frame": 21, "eye": [0, 60, 0]}], "vertical_fov_deg": 40})";

TEST(CameraMotion, IsLinearBetweenKeysAndHoldsOutside) {
  const auto camera = described(keys);
  for (const auto frame : {std::optional<int>(), std::optional<int>(0), std::optional<int>(10)}) {
    EXPECT_EQ(at(camera, frame).eye, glm::vec3(0, -50, 0));
    EXPECT_EQ(at(camera, frame).vertical_fov_deg, 20);
  }
  EXPECT_EQ(at(camera, 15).eye, glm::vec3(25, -50, 5));
  EXPECT_EQ(at(camera, 15).look_at, glm::vec3(0, 0, 2));
  EXPECT_EQ(at(camera, 15).vertical_fov_deg, 30);
  EXPECT_EQ(at(camera, 20).eye, glm::vec3(50, -50, 10));
  EXPECT_EQ(at(camera, 21).eye, glm::vec3(0, 60, 0));
  EXPECT_EQ(at(camera, 1000000).eye, glm::vec3(0, 60, 0));
}

TEST(CameraMotion, NamesTheFrameThatSeesNothing) {
  const auto through = described(R"({"frames": [{"frame": 0, "eye": [0, -50, 0]}, {"frame": 2, "eye": [0, 50, 0]}]})");
  EXPECT_EQ(camera_at(through, 1, {}, Image{}, "s.json").error().message(),
            "s.json: /camera at frame 1: look_at: expected a point other than eye, found the same point");
}

TEST(CameraMotion, StraightUpOrDownNeedsNoUp) {
  for (const char* camera : {R"({"eye": [0, 0, 20], "look_at": [0, 0, 0]})", R"({"eye": [0, 0, -20]})",
                             R"({"frames": [{"frame": 0, "eye": [0, 0, 3]}]})"})
    EXPECT_EQ(at(described(camera), 0).up, glm::vec3(0, 1, 0)) << camera;
  EXPECT_EQ(at(described(R"({"eye": [0, -9, 20]})"), 0).up, glm::vec3(0, 0, 1));
  EXPECT_FALSE(parse(R"({"eye": [0, 0, 20], "up": [0, 0, 1]})")) << "it was said, and is along the view";
}

TEST(CameraMotion, RefusesWhatContradicts) {
  const std::pair<std::string, std::string> wrong[] = {
      {R"({"frames": []})", "/camera/frames: expected one frame or more, found none"},
      {R"({"frames": [{"frame": 0}]})", "/camera/frames/0/eye: expected this key"},
      {R"({"frames": [{"eye": [1, 2, 3]}]})", "/camera/frames/0/frame: expected this key"},
      {R"({"frames": [{"frame": 3, "eye": [1, 2, 3]}, {"frame": 3, "eye": [1, 2, 3]}]})",
       "/camera/frames/1/frame: expected more than 3, the frame before, found 3"},
      {R"({"frames": [{"frame": 3, "eye": [0, 0, 3], "up": [0, 0, 2]}]})", "/camera/frames/0/up"},
      {R"({"frames": [{"frame": 3, "eye": [0, 1, 3]}], "eye": [1, 2, 3]})", "/camera: expected frames or turntable"},
      {R"({"frames": [{"frame": 3, "eye": [0, 1, 3]}], "turntable": {"frames": 3}})", "/camera: expected at most one"},
      {R"({"turntable": {}})", "/camera/turntable/frames: expected this key"},
      {R"({"turntable": {"frames": 4, "height_cm": 3}})", "/camera/turntable/height_cm"},
      {R"({"turntable": {"frames": 4, "turns": "light"}})", "/camera/turntable/turns: expected one of object, camera"},
      {R"({"turntable": {"frames": 4, "distance_cm": 0.001, "height_cm": 1000}})", "/camera/turntable/up"}};
  for (const auto& [text, why] : wrong) {
    const auto scene = parse(text);
    ASSERT_FALSE(scene) << text;
    EXPECT_NE(scene.error().message().find(why), std::string::npos) << scene.error().message();
  }
}

TEST(CameraMotion, TurntableGoesCounterClockwiseFromTheFront) {
  const auto camera = described(
      R"({"turntable": {"frames": 4, "look_at": [1, 2, 3], "distance_cm": 10, "height_cm": 5, "turns": "camera"},
          "vertical_fov_deg": 33})");
  const glm::vec3 eyes[] = {{1, -8, 8}, {11, 2, 8}, {1, 12, 8}, {-9, 2, 8}, {1, -8, 8}};
  for (int frame = 0; frame < 5; ++frame) {
    const auto now = at(camera, frame);
    EXPECT_LT(glm::distance(now.eye, eyes[frame]), 1e-5f) << frame;
    EXPECT_EQ(now.look_at, glm::vec3(1, 2, 3));
    EXPECT_EQ(now.vertical_fov_deg, 33);
  }
}

/// Half the angles that a point takes in the picture, over those of view: 1 at the edge.
double reach(const Camera& camera, const Image& image, const glm::vec3& point) {
  const glm::vec3 forward = glm::normalize(camera.look_at - camera.eye);
  const glm::vec3 right = glm::normalize(glm::cross(forward, camera.up)), up = glm::cross(right, forward);
  const glm::vec3 d = point - camera.eye;
  const double tangent = std::tan(camera.vertical_fov_deg / 2 * std::numbers::pi / 180), depth = glm::dot(d, forward);
  return std::max(std::abs(glm::dot(d, up)) / depth / tangent,
                  std::abs(glm::dot(d, right)) / depth / tangent * image.height / image.width);
}

/// A point reaches 1/1.06 where it decides the distance: somewhere on the way round, in a finely divided turn.
TEST(CameraMotion, FramedTurntableSeesAllHairAllRoundAndNoLess) {
  const std::vector<Groom> grooms{generate_groom({.kind = "curly_lock", .strands = 60, .seed = 4})};
  for (const char* aim : {"", R"(, "look_at": [3, 1, -20])"})
    for (const Image& image : {Image{400, 400, 1}, Image{200, 600, 1}, Image{800, 200, 1}}) {
      const auto camera = described(std::string(R"({"turntable": {"turns": "camera", "frames": 360)") + aim + "}}");
      double most = 0;
      for (int frame = 0; frame < 360; frame += 1) {
        const auto now = camera_at(camera, frame, grooms, image, "s.json");
        ASSERT_TRUE(now);
        for (const auto& p : grooms[0].points) most = std::max(most, reach(*now, image, p));
      }
      EXPECT_LE(most, 1 / 1.06 + 1e-4);
      EXPECT_GE(most, 1 / 1.06 - 2e-3);
    }
}

/// As `turns` has it, a frame shows the same side of the hair: where a point is seen from the camera.
TEST(CameraMotion, ATurntableOfObjectsStandsStillAndShowsWhatTheTurningCameraSees) {
  const std::vector<Groom> grooms{generate_groom({.kind = "curly_lock", .strands = 20, .seed = 4})};
  const Image image{300, 400, 1};
  for (const char* aim : {"", R"(, "look_at": [3, 1, -20])", R"(, "distance_cm": 40, "height_cm": 7)"}) {
    const auto turning = described(fmt::format(R"({{"turntable": {{"frames": 24, "turns": "camera"{}}}}})", aim));
    const auto still = described(fmt::format(R"({{"turntable": {{"frames": 24{}}}}})", aim));
    for (const int frame : {0, 1, 7, 12, 31}) {
      const auto camera = camera_at(turning, frame, grooms, image, "s.json");
      const auto fixed = camera_at(still, frame, grooms, image, "s.json");
      ASSERT_TRUE(camera && fixed);
      EXPECT_EQ(fixed->eye, camera_at(still, 0, grooms, image, "s.json")->eye);
      EXPECT_EQ(object_turn_at(turning, frame, grooms).turn_rad, 0);
      std::vector<Groom> turned = grooms;
      std::vector<Mesh> meshes(1);
      meshes[0].positions = {grooms[0].points[0]};
      meshes[0].normals = {glm::normalize(camera->eye - camera->look_at)};
      turn_objects(std::array{object_turn_at(still, frame, grooms)}, &turned, &meshes);
      EXPECT_EQ(meshes[0].positions[0], turned[0].points[0]);
      EXPECT_LT(glm::distance(meshes[0].normals[0], glm::normalize(fixed->eye - fixed->look_at)), 1e-6f);
      const auto seen = [](const Camera& by, const glm::vec3& point) {
        const glm::vec3 forward = glm::normalize(by.look_at - by.eye), d = point - by.eye;
        const glm::vec3 right = glm::normalize(glm::cross(forward, by.up));
        return glm::vec3(glm::dot(d, right), glm::dot(d, glm::cross(right, forward)), glm::dot(d, forward));
      };
      for (std::size_t i = 0; i < grooms[0].points.size(); i += 37)
        EXPECT_LT(glm::distance(seen(*camera, grooms[0].points[i]), seen(*fixed, turned[0].points[i])), 1e-4f);
    }
  }
}

TEST(CameraMotion, AFramedCameraTurnsAboutTheHair) {
  const std::vector<Groom> grooms{generate_groom({.kind = "straight", .strands = 60, .seed = 4})};
  const Image image{400, 600, 1};
  const glm::vec3 from =
      camera_at({}, {}, grooms, image, "s.json")->eye - camera_at({}, {}, grooms, image, "s.json")->look_at;
  EXPECT_EQ(from.x, 0);
  EXPECT_LT(from.y, 0);
  for (const double turn_deg : {-90.0, 0.0, 30.0, 90.0, 180.0, 360.0}) {
    const auto description = described(fmt::format(R"({{"turn_deg": {}}})", turn_deg));
    const auto camera = camera_at(description, {}, grooms, image, "s.json");
    ASSERT_TRUE(camera);
    const glm::vec3 eye = camera->eye - camera->look_at;
    const double azimuth = std::atan2(eye.x, -eye.y) * 180 / std::numbers::pi;
    EXPECT_NEAR(std::remainder(azimuth - turn_deg, 360), 0, 1e-3);
    double most = 0;
    for (const auto& p : grooms[0].points) most = std::max(most, reach(*camera, image, p));
    EXPECT_NEAR(most, 1 / 1.06, 1e-4);  // no point is outside, and one decides the distance
  }
}

TEST(LoadScene, TurnsACameraThatItPlacesAndNoOther) {
  const auto file = std::filesystem::path(testing::TempDir()) / "tress_turn.json";
  std::ofstream(file) << "{" << groom << "}";
  Overrides overrides;
  overrides.settings = {"camera/turn_deg=90"};
  const auto scene = load_scene(file, overrides);
  std::ofstream(file) << R"({"camera": {"eye": [0, -60, 0]}, )" << groom << "}";
  const auto placed = load_scene(file, overrides);
  std::filesystem::remove(file);
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_GT(scene->camera.eye.x - scene->camera.look_at.x, 1);
  ASSERT_FALSE(placed);
  EXPECT_EQ(placed.error().place, "/camera/turn_deg");
}

TEST(LoadScene, TakesTheCameraOfTheFrame) {
  const auto file = std::filesystem::path(testing::TempDir()) / "tress_frames.json";
  std::ofstream(file) << R"({"camera": )" << keys << ", " << groom << "}";
  Overrides overrides;
  overrides.frame = 15;
  const auto scene = load_scene(file, overrides);
  std::filesystem::remove(file);
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_EQ(scene->camera.eye, glm::vec3(25, -50, 5));
  const auto still = load_scene(std::filesystem::path(TRESS_SOURCE_DIR) / "scenes" / "furnace.json", overrides);
  ASSERT_TRUE(still);
  EXPECT_NE(std::find_if(still->notes.begin(), still->notes.end(),
                         [](const std::string& note) { return note.find("every frame is the same") != note.npos; }),
            still->notes.end());
}

}  // namespace
}  // namespace tress::scene
