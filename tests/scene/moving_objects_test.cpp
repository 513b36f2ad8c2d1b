// Scenes whose camera, grooms and meshes move while the shutter is open: keyframes, turntables, a file a frame.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <string>
#include <vector>

#include "scene/model/camera.h"
#include "scene/read/load_scene.h"

namespace tress::scene {
namespace {

class MovingScene : public testing::Test {
 protected:
  MovingScene() {
    folder_ = std::filesystem::temp_directory_path() / fmt::format("tress_moving_scene_{}", getpid());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  ~MovingScene() override { std::filesystem::remove_all(folder_); }

  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }

  /// PLY strands with ids: two of two points.
  void write_strands(const std::string& name, const std::vector<std::array<double, 4>>& points) const {
    std::string text = fmt::format(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
        "property int strand_id\nend_header\n",
        points.size());
    for (const auto& p : points) text += fmt::format("{} {} {} {}\n", p[0], p[1], p[2], p[3]);
    write(name, text);
  }

  Result<Scene> load(const std::string& camera, const std::string& objects, const Overrides& overrides = {}) const {
    write("s.json", fmt::format(R"({{"camera": {}, {}}})", camera, objects));
    return load_scene(folder_ / "s.json", overrides);
  }

  std::filesystem::path folder_;
};

const std::string fiber = R"("grooms": [{"generate": "single_fiber"}])";
const std::string numbered = R"("grooms": [{"file": "a.####.ply", "basis": "linear", "cm_per_unit": 1, "up": "z"}])";
const std::string from_before = R"({"eye": [0, -50, 0], "shutter": {"open": 0.25, "close": 0.75}})";

TEST_F(MovingScene, AClosedShutterLeavesEverythingAtItsFrame) {
  const auto scene = load(R"({"frames": [{"frame": 0, "eye": [0, -50, 0]}, {"frame": 10, "eye": [10, -50, 0]}]})",
                          fiber, {.frame = 4});
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_FALSE(scene->shutter.is_open());
  EXPECT_TRUE(scene->camera_moments.empty());
  EXPECT_TRUE(scene->grooms[0].later.empty());
  EXPECT_NEAR(scene->camera.eye.x, 4, 1e-5);
}

TEST_F(MovingScene, ACameraGoesOnBetweenFrames) {
  const auto scene = load(R"({"frames": [{"frame": 0, "eye": [0, -50, 0]}, {"frame": 10, "eye": [10, -50, 0]}],
                              "motion_samples": 3})",
                          fiber, {.settings = {R"(camera/shutter={"open": -0.5, "close": 0.5})"}, .frame = 4});
  ASSERT_TRUE(scene) << scene.error().message();
  ASSERT_EQ(scene->camera_moments.size(), 3u);
  EXPECT_NEAR(scene->camera.eye.x, 4, 1e-5) << "that of the header is of the frame";
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(scene->camera_moments[i].eye.x, 3.5f + 0.5f * static_cast<float>(i), 1e-5);
    EXPECT_NEAR(scene->next->moments[i].eye.x, 4.5f + 0.5f * static_cast<float>(i), 1e-5);
  }
  EXPECT_NEAR(camera_during(scene->camera_moments, 0.75f).eye.x, 4.25, 1e-5);
  EXPECT_TRUE(scene->grooms[0].later.empty());
}

/// A quarter of the way between two frames of a turn of four, about the z axis: 22.5 degrees clockwise.
TEST_F(MovingScene, ATurntableTurnsObjectsWhileTheShutterIsOpen) {
  const auto scene = load(R"({"turntable": {"frames": 4, "look_at": [1, 0, 0], "distance_cm": 40},
                              "shutter": {"open": 0, "close": 0.25}})",
                          R"("grooms": [{"generate": "single_fiber", "translate": [3, 0, 0]}])", {.frame = 0});
  ASSERT_TRUE(scene) << scene.error().message();
  const Groom& groom = scene->grooms[0];
  ASSERT_EQ(groom.later.size(), 1u);
  const double angle = -std::acos(-1.0) / 8;
  for (std::size_t i = 0; i < groom.points.size(); ++i) {
    const glm::dvec3 from = glm::dvec3(groom.points[i]) - glm::dvec3(1, 0, 0), to = groom.later[0].points[i];
    EXPECT_NEAR(to.x, 1 + std::cos(angle) * from.x - std::sin(angle) * from.y, 1e-4);
    EXPECT_NEAR(to.y, std::sin(angle) * from.x + std::cos(angle) * from.y, 1e-4);
  }
  EXPECT_NEAR(groom.later[0].turned[0][1], std::sin(angle), 1e-9);
  EXPECT_TRUE(scene->camera_moments.empty()) << "the camera of such a turntable stands";
}

TEST_F(MovingScene, GroomsAndMeshesFollowTheirKeys) {
  write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 1 0 0\nf 1//1 2//1 3//1\n");
  const std::string keys = R"("frames": [{"frame": 10, "translate": [0, 0, 0]},
                                         {"frame": 20, "translate": [10, 0, 0], "rotate_deg": [0, 0, 90], "scale": 3}])";
  const auto scene = load(from_before,
                          R"("grooms": [{"generate": "single_fiber", "translate": [0, 0, 5], )" + keys +
                              R"(}], "meshes": [{"file": "m.obj", "scale": 2, )" + keys + "}]",
                          {.frame = 15});
  ASSERT_TRUE(scene) << scene.error().message();
  const Mesh& mesh = scene->meshes[0];
  ASSERT_EQ(mesh.later.size(), 1u);
  // At frame 15.25 and 15.75: scale 2.525 and 2.575, 47.25 and 51.75 degrees, 5.25 and 5.75 cm.
  const double degree = std::acos(-1.0) / 180;
  EXPECT_NEAR(mesh.positions[1].x, 2.525 * std::cos(47.25 * degree) + 5.25, 1e-5);
  EXPECT_NEAR(mesh.positions[1].y, 2.525 * std::sin(47.25 * degree), 1e-5);
  EXPECT_NEAR(mesh.later[0].positions[1].y, 2.575 * std::sin(51.75 * degree), 1e-5);
  EXPECT_NEAR(mesh.later[0].normals[0].y, std::sin(51.75 * degree), 1e-5);
  const Groom& groom = scene->grooms[0];
  ASSERT_EQ(groom.later.size(), 1u);
  EXPECT_NEAR(groom.later[0].turned[0][1], std::sin(4.5 * degree), 1e-6) << "turns are floats";
  EXPECT_GT(groom.points[0].x, 5);
  ASSERT_TRUE(scene->next.has_value());
}

/// At frames 15.25 and 15.75, of keys at 10 and 20.
TEST_F(MovingScene, LightsFollowTheirKeys) {
  const auto scene = load(from_before, fiber + R"(, "lights": [
    {"sphere": {"center": [1, 0, 0], "radius_cm": 2, "radiance": [1, 1, 1]}, "frames": [
      {"frame": 10, "rotate_deg": [0, 0, 0]}, {"frame": 20, "rotate_deg": [0, 0, 90], "translate": [10, 0, 0], "scale": 3}]},
    {"rectangle": {"center": [0, 0, 5], "look_at": [0, 0, 0], "width_cm": 4, "height_cm": 2, "radiance": [1, 1, 1]},
     "translate": [0, 0, 1]},
    {"distant": {"direction": [1, 0, 0], "radiance": [1, 1, 1]}, "frames": [
      {"frame": 10}, {"frame": 20, "rotate_deg": [0, 0, 90]}]}])",
                          {.frame = 15});
  ASSERT_TRUE(scene) << scene.error().message();
  const double degree = std::acos(-1.0) / 180;
  const Light& ball = scene->lights[0];
  ASSERT_EQ(ball.later.size(), 1u);
  EXPECT_NEAR(ball.center.x, 2.05 * std::cos(47.25 * degree) + 5.25, 1e-5);
  EXPECT_NEAR(ball.later[0].center.y, 2.15 * std::sin(51.75 * degree), 1e-5);
  EXPECT_NEAR(ball.radius_cm, 4.1, 1e-5);
  EXPECT_NEAR(ball.later[0].radius_cm, 4.3, 1e-5);
  EXPECT_EQ(scene->lights[1].center, glm::vec3(0, 0, 6));
  EXPECT_TRUE(scene->lights[1].later.empty()) << "it rests";
  EXPECT_NEAR(scene->lights[2].direction.y, std::sin(47.25 * degree), 1e-6);
  EXPECT_NEAR(scene->lights[2].later[0].direction.y, std::sin(51.75 * degree), 1e-6);
  EXPECT_FALSE(scene->next) << "nothing that the camera sees moves";
  const auto late =
      load(R"({"eye": [0, -50, 0]})", fiber + R"(, "lights": [{"sphere": {"center": [0, 0, 0], "radius_cm": 1,
    "radiance": [1, 1, 1]}, "frames": [{"frame": 1, "translate": [2e6, 0, 0]}]}])");
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().place, "/lights/0/frames/0/translate/0") << late.error().message();
}

/// The sun turns with its sky; --rotate holds both still.
TEST_F(MovingScene, AnEnvironmentTurnsByItsKeys) {
  const std::string sky = fiber + R"(, "environment": {"sky": {"sun": {"direction": [1, 0, 0], "radiance": [9, 9, 9]}},
    "frames": [{"frame": 10, "rotate_deg": 0}, {"frame": 20, "rotate_deg": 90}]})";
  const auto scene = load(from_before, sky, {.frame = 15});
  ASSERT_TRUE(scene) << scene.error().message();
  const double degree = std::acos(-1.0) / 180;
  ASSERT_EQ(scene->environment_turns_rad.size(), 2u);
  EXPECT_EQ(scene->environment_turns_rad[0], 0);
  EXPECT_NEAR(scene->environment_turns_rad[1], 4.5 * degree, 1e-6);
  ASSERT_EQ(scene->lights.size(), 1u);
  EXPECT_NEAR(scene->lights[0].direction.y, std::sin(47.25 * degree), 1e-6);
  ASSERT_EQ(scene->lights[0].later.size(), 1u);
  EXPECT_NEAR(scene->lights[0].later[0].direction.y, std::sin(51.75 * degree), 1e-6);
  ASSERT_TRUE(scene->next);
  EXPECT_NEAR(scene->next->environment_turn_rad, 9 * degree, 1e-9);
  const auto held =
      load(from_before, sky, {.settings = {"environment/frames=null", "environment/rotate_deg=90"}, .frame = 15});
  ASSERT_TRUE(held) << held.error().message();
  EXPECT_TRUE(held->environment_turns_rad.empty());
  EXPECT_NEAR(held->lights[0].direction.y, 1, 1e-6);
  EXPECT_TRUE(held->lights[0].later.empty());
}

TEST_F(MovingScene, FilesOfFramesAreReadAroundTheShutterAndMetInBetween) {
  write_strands("a.0007.ply", {{0, 0, 0, 1}, {0, 0, 1, 1}, {5, 0, 0, 2}, {5, 0, 1, 2}});
  write_strands("a.0008.ply", {{4, 0, 0, 1}, {4, 8, 1, 1}, {5, 0, 2, 2}, {5, 0, 3, 2}});
  const auto scene = load(from_before, numbered, {.frame = 7});
  ASSERT_TRUE(scene) << scene.error().message();
  const Groom& groom = scene->grooms[0];
  ASSERT_EQ(groom.points.size(), 4u);
  EXPECT_EQ(groom.points[1], glm::vec3(1, 2, 1));
  ASSERT_EQ(groom.later.size(), 1u);
  EXPECT_EQ(groom.later[0].points[1], glm::vec3(3, 6, 1));
  EXPECT_EQ(groom.later[0].points[3], glm::vec3(5, 0, 2.5f));
  const auto still = load(R"({"eye": [0, -50, 0]})", numbered, {.frame = 8});
  ASSERT_TRUE(still) << still.error().message();
  EXPECT_EQ(still->grooms[0].points[1], glm::vec3(4, 8, 1));
  EXPECT_TRUE(still->grooms[0].later.empty());
}

/// Linear curves with ids.
std::string curves(const std::string& counts, const std::string& points, const std::string& ids) {
  return fmt::format(
      "#usda 1.0\n( metersPerUnit = 0.01\n upAxis = \"Z\" )\ndef BasisCurves \"hair\" {{\n"
      "uniform token type = \"linear\"\nint[] curveVertexCounts = [{}]\npoint3f[] points = [{}]\n"
      "int[] primvars:id = [{}] ( interpolation = \"uniform\" )\n}}\n",
      counts, points, ids);
}

TEST_F(MovingScene, StrandsInAnotherOrderAreMatchedByTheirIds) {
  write("b.0000.usda", curves("2, 3", "(0,0,0), (0,0,1), (5,0,0), (5,0,1), (5,0,2)", "1, 2"));
  write("b.0001.usda", curves("3, 2", "(5,4,0), (5,4,1), (5,4,2), (0,4,0), (0,4,1)", "2, 1"));
  const std::string grooms = R"("grooms": [{"file": "b.####.usda"}])";
  const auto scene = load(from_before, grooms, {.frame = 0});
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_EQ(scene->grooms[0].later[0].points[0], glm::vec3(0, 3, 0));
  EXPECT_EQ(scene->grooms[0].later[0].points[4], glm::vec3(5, 3, 2));
  write("b.0001.usda", curves("3, 2", "(5,4,0), (5,4,1), (5,4,2), (0,4,0), (0,4,1)", "2, 3"));
  EXPECT_FALSE(load(from_before, grooms, {.frame = 0})) << "another strand, and the counts differ";
}

/// Diameters 0.02 and 0.04 at frame 0, 0.06 and 0.04 at frame 1: at 0.25 and 0.75 of the way. Strands are matched by
/// id.
TEST_F(MovingScene, RadiiGoWithTheStrands) {
  const auto with_widths = [](std::string text, const std::string& widths) {
    const std::string end = "\n}\n";
    return text.replace(text.rfind(end), end.size(),
                        "\nfloat[] widths = [" + widths + "] ( interpolation = \"vertex\" )\n}\n");
  };
  write("w.0000.usda",
        with_widths(curves("2, 2", "(0,0,0), (0,0,1), (5,0,0), (5,0,1)", "1, 2"), "0.02, 0.02, 0.04, 0.04"));
  write("w.0001.usda",
        with_widths(curves("2, 2", "(5,4,0), (5,4,1), (0,4,0), (0,4,1)", "2, 1"), "0.04, 0.04, 0.06, 0.06"));
  const auto scene = load(from_before, R"("grooms": [{"file": "w.####.usda", "scale": 2}])", {.frame = 0});
  ASSERT_TRUE(scene) << scene.error().message();
  const Groom& groom = scene->grooms[0];
  EXPECT_NEAR(groom.radius_cm[0], 0.03, 1e-6);
  ASSERT_EQ(groom.later.size(), 1u);
  ASSERT_EQ(groom.later[0].radius_cm.size(), 4u);
  EXPECT_NEAR(groom.later[0].radius_cm[0], 0.05, 1e-6);
  EXPECT_NEAR(groom.later[0].radius_cm[3], 0.04, 1e-6);
  const auto grown =
      load(from_before, R"("grooms": [{"file": "w.0000.usda", "frames": [{"frame": 0}, {"frame": 1, "scale": 3}]}])",
           {.frame = 0});
  ASSERT_TRUE(grown) << grown.error().message();
  EXPECT_NEAR(grown->grooms[0].radius_cm[0], 0.015, 1e-6);
  EXPECT_NEAR(grown->grooms[0].later[0].radius_cm[0], 0.025, 1e-6);
}

TEST_F(MovingScene, AChangedNumberOfPointsOrStrandsIsRefusedByName) {
  const auto name = [&](const char* file) { return (folder_ / file).string(); };
  write_strands("a.0000.ply", {{0, 0, 0, 1}, {0, 0, 1, 1}, {5, 0, 0, 2}, {5, 0, 1, 2}});
  write_strands("a.0001.ply", {{0, 0, 0, 1}, {0, 0, 1, 1}, {5, 0, 0, 2}, {5, 0, 1, 2}, {5, 0, 2, 2}});
  EXPECT_EQ(load(from_before, numbered, {.frame = 0}).error().message(),
            fmt::format("{}: strand 1: expected the 2 points of {}, found 3", name("a.0001.ply"), name("a.0000.ply")));
  write_strands("a.0001.ply", {{0, 0, 0, 1}, {0, 0, 1, 1}});
  EXPECT_EQ(load(from_before, numbered, {.frame = 0}).error().message(),
            fmt::format("{}: strands: expected the 2 of {}, since strands move from one to the other, found 1",
                        name("a.0001.ply"), name("a.0000.ply")));
  EXPECT_EQ(load(from_before, numbered, {.frame = 1}).error().file, name("a.0002.ply")) << "no such file";
}

const std::filesystem::path fixtures = std::filesystem::path(TRESS_SOURCE_DIR) / "tests" / "scene" / "grooms";

/// moving.abc (make_fixtures.py): at frame 10 at x = 0, at 11 at x = 8, at 12 bent by 2 along y and raised by 16. The
/// third strand has one sample, at frame 10, and velocities of 1 and 2 cm a frame.
TEST_F(MovingScene, AlembicIsReadBetweenItsSamples) {
  const std::string groom =
      R"("grooms": [{"file": ")" + (fixtures / "moving.abc").string() + R"(", "cm_per_unit": 1, "up": "z"}])";
  const auto scene = load(from_before, groom, {.frame = 10});
  ASSERT_TRUE(scene) << scene.error().message();
  const Groom& early = scene->grooms[0];
  ASSERT_EQ(early.points.size(), 6u);
  ASSERT_EQ(early.later.size(), 1u);
  EXPECT_LT(glm::distance(early.points[0], glm::vec3(2, 0, 0)), 1e-5);
  EXPECT_LT(glm::distance(early.later[0].points[3], glm::vec3(10, 0, 1)), 1e-5);
  EXPECT_LT(glm::distance(early.points[4], glm::vec3(0.25, 9, 0)), 1e-5);
  EXPECT_LT(glm::distance(early.later[0].points[5], glm::vec3(1.5, 9, 1)), 1e-5);
  const auto late = load(R"({"eye": [0, -50, 0]})", groom, {.frame = 12});
  ASSERT_TRUE(late) << late.error().message();
  EXPECT_LT(glm::distance(late->grooms[0].points[3], glm::vec3(12, 2, 17)), 1e-5);
  EXPECT_TRUE(late->grooms[0].later.empty());
  const auto half_speed = load(R"({"eye": [0, -50, 0], "frames_per_second": 48})", groom, {.frame = 21});
  ASSERT_TRUE(half_speed) << half_speed.error().message();
  EXPECT_LT(glm::distance(half_speed->grooms[0].points[0], glm::vec3(4, 0, 0)), 1e-5);
  const auto first = load(R"({"eye": [0, -50, 0]})", groom);
  ASSERT_TRUE(first) << first.error().message();
  EXPECT_EQ(first->grooms[0].points[0], glm::vec3(0, 0, 0)) << "no frame was asked for: the first sample";
  const auto grown =
      load(from_before, R"("grooms": [{"file": ")" + (fixtures / "growing.abc").string() + "\"}]", {.frame = 0});
  ASSERT_FALSE(grown);
  EXPECT_EQ(grown.error().place, "/hair: nVertices");
}

TEST_F(MovingScene, UsdIsReadBetweenItsTimeSamples) {
  const std::string head =
      "#usda 1.0\n( metersPerUnit = 0.01\n upAxis = \"Z\" )\ndef Xform \"up\" {\n"
      "double3 xformOp:translate = (9, 9, 9)\n"
      "double3 xformOp:translate.timeSamples = { 3: (0, 0, 0), 4: (0, 0, 16) }\n"
      "uniform token[] xformOpOrder = [\"xformOp:translate\"]\ndef BasisCurves \"hair\" {\n"
      "uniform token type = \"linear\"\nint[] curveVertexCounts = [2]\n";
  write("c.usda", head +
                      "point3f[] points.timeSamples = { 3: [(0,0,0), (0,0,1)], 4: [(8,0,0), (8,4,1)] }\n"
                      "point3f[] points = [(7,7,7), (8,8,8)]\n}\n}\n");
  const std::string grooms = R"("grooms": [{"file": "c.usda"}])";
  const auto scene = load(from_before, grooms, {.frame = 3});
  ASSERT_TRUE(scene) << scene.error().message();
  const Groom& groom = scene->grooms[0];
  ASSERT_EQ(groom.later.size(), 1u);
  EXPECT_EQ(groom.points[1], glm::vec3(2, 1, 5));
  EXPECT_EQ(groom.later[0].points[1], glm::vec3(6, 3, 13));
  const auto after = load(R"({"eye": [0, -50, 0]})", grooms, {.frame = 9});
  ASSERT_TRUE(after) << after.error().message();
  EXPECT_EQ(after->grooms[0].points[1], glm::vec3(8, 4, 17)) << "the last sample holds";
  write("c.usda", head + "point3f[] points.timeSamples = { 3: [(0,0,0), (0,0,1)], 4: [(8,0,0)] }\n}\n}\n");
  const auto changed = load(from_before, grooms, {.frame = 3});
  ASSERT_TRUE(changed) << changed.error().message();
  EXPECT_EQ(changed->grooms[0].points[1], glm::vec3(0, 0, 5)) << "the sample before holds, its prim moves";
  write("c.usda", head +
                      "vector3f[] velocities = [(24, 0, 0), (48, 0, 0)]\n"
                      "point3f[] points.timeSamples = { 3: [(0,0,0), (0,0,1)], 4: [(8,0,0)] }\n}\n}\n");
  const auto moved = load(from_before, grooms, {.frame = 3});
  ASSERT_TRUE(moved) << moved.error().message();
  EXPECT_EQ(moved->grooms[0].points[1], glm::vec3(0.5f, 0, 5)) << "a quarter of a frame at 48 units a second";
  EXPECT_EQ(moved->grooms[0].later[0].points[1], glm::vec3(1.5f, 0, 13));
}

TEST_F(MovingScene, MeshesOfFramesMustHaveTheSameFaces) {
  const std::string square = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\n", raised = "v 0 0 4\nv 2 0 4\nv 2 2 4\nv 0 2 4\n";
  write("m.01.obj", square + "vn 0 0 1\nf 1//1 2//1 3//1 4//1\n");
  write("m.02.obj", raised + "vn 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//2 4//2\n");
  const std::string meshes = fiber + R"(, "meshes": [{"file": "m.##.obj"}])";
  const auto scene = load(from_before, meshes, {.frame = 1});
  ASSERT_TRUE(scene) << scene.error().message();
  const Mesh& mesh = scene->meshes[0];
  EXPECT_EQ(mesh.positions[2], glm::vec3(2, 2, 1));
  ASSERT_EQ(mesh.later.size(), 1u);
  EXPECT_EQ(mesh.later[0].positions[2], glm::vec3(2, 2, 3));
  const glm::vec3 normal = mesh.later[0].normals[mesh.corner_normals[0].x];
  EXPECT_LT(glm::distance(normal, glm::normalize(glm::vec3(0, 3, 1))), 1e-5) << "by corners, as the files number apart";
  write("m.02.obj", raised + "vn 0 0 1\nf 4//1 3//1 2//1 1//1\n");
  const auto other = load(from_before, meshes, {.frame = 1});
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().message(),
            fmt::format("{}: triangles: expected the 2 of {}, since they move from one to the other, found others",
                        (folder_ / "m.02.obj").string(), (folder_ / "m.01.obj").string()));
}

TEST_F(MovingScene, AShutterThatClosesBeforeItOpensIsRefused) {
  EXPECT_EQ(load(R"({"eye": [0, -50, 0], "shutter": {"open": 0.5, "close": 0.25}})", fiber).error().place,
            "/camera/shutter");
}

}  // namespace
}  // namespace tress::scene
