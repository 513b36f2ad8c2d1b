// What a camera is made of beside its place: focal length and sensor, focus, and what is refused.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "scene/model/camera.h"
#include "scene/read/scene_file.h"

namespace tress::scene {
namespace {

Result<SceneDescription> parse(const std::string& keys) {
  const std::string text = R"({"camera": {)" + keys + R"(}, "grooms": [{"generate": "single_fiber"}]})";
  return parse_scene_file(std::vector<unsigned char>(text.begin(), text.end()), "s.json");
}

Result<Camera> camera_of(const std::string& keys, int width, int height, std::optional<int> frame = {}) {
  const auto scene = parse(keys);
  if (!scene) return scene.error();
  return camera_at(scene->camera, frame, {}, Image{width, height, 1}, "s.json");
}

double angle_deg(double side_mm, double focal_mm) {
  return 2 * std::atan(side_mm / 2 / focal_mm) * 180 / std::numbers::pi;
}

TEST(Lens, FocalLengthsAndTheSensorGiveTheAngleThatTheyHaveOnACamera) {
  const std::string at = R"("eye": [0, -50, 0], )";
  const auto fov = [&](const std::string& keys, int width, int height) {
    const auto camera = camera_of(at + keys, width, height);
    EXPECT_TRUE(camera) << camera.error().message();
    return camera ? camera->vertical_fov_deg : 0;
  };
  // 50 mm on 36 x 24: 27.0 degrees high, held upright 39.6.
  EXPECT_NEAR(fov(R"("focal_length_mm": 50)", 300, 200), angle_deg(24, 50), 1e-4);
  EXPECT_NEAR(fov(R"("focal_length_mm": 50)", 200, 300), angle_deg(36, 50), 1e-4);
  EXPECT_NEAR(fov(R"("focal_length_mm": 50, "sensor_fit": "width")", 200, 300), angle_deg(54, 50), 1e-4);
  EXPECT_NEAR(fov(R"("focal_length_mm": 50, "sensor_fit": "height")", 300, 200), angle_deg(36, 50), 1e-4);
  EXPECT_NEAR(fov(R"("focal_length_mm": 35, "sensor_mm": 24.9)", 300, 200), angle_deg(16.6, 35), 1e-4);
  // And back: the focal length of an angle.
  EXPECT_NEAR(camera_of(at + fmt::format(R"("vertical_fov_deg": {})", angle_deg(24, 85)), 300, 200)->focal_length_mm,
              85, 1e-3);
}

TEST(Lens, TheApertureIsTheFocalLengthOverTheFNumberAndTheFocusIsOnWhatIsLookedAt) {
  const std::string at = R"("eye": [0, -50, 0], "look_at": [0, 10, 0], "focal_length_mm": 50, )";
  const auto of = [&](const std::string& lens) {
    const auto camera = camera_of(at + R"("depth_of_field": {)" + lens + "}", 300, 200);
    EXPECT_TRUE(camera) << camera.error().message();
    return camera ? *camera : Camera{};
  };
  EXPECT_NEAR(of(R"("f_number": 2)").lens_radius_cm, 1.25, 1e-5);
  EXPECT_EQ(of(R"("radius_cm": 3)").lens_radius_cm, 3);
  EXPECT_NEAR(of(R"("f_number": 2)").focus_cm, 60, 1e-4);
  EXPECT_EQ(of(R"("f_number": 2, "focus_cm": 44)").focus_cm, 44);
  EXPECT_NEAR(of(R"("f_number": 2, "focus_point": [30, -20, 4])").focus_cm, 30, 1e-4) << "along the view";
  EXPECT_EQ(of(R"("f_number": 2, "blades": 6, "blade_rotation_deg": 90)").blades, 6);
  EXPECT_EQ(camera_of(at + R"("shift_x": 0.5)", 300, 200)->lens_radius_cm, 0) << "a pinhole";
}

TEST(Lens, KeyframesMayHaveFocalLengthsAndPullTheFocus) {
  const std::string keys = R"("frames": [{"frame": 0, "eye": [0, -50, 0], "focal_length_mm": 50},
      {"frame": 2, "eye": [0, -50, 0], "look_at": [0, 50, 0], "vertical_fov_deg": 40}], "depth_of_field": {"f_number": 4})";
  const auto first = camera_of(keys, 300, 200, 0), middle = camera_of(keys, 300, 200, 1);
  ASSERT_TRUE(first && middle);
  EXPECT_NEAR(first->vertical_fov_deg, angle_deg(24, 50), 1e-4);
  EXPECT_NEAR(middle->vertical_fov_deg, (angle_deg(24, 50) + 40) / 2, 1e-4);
  EXPECT_NEAR(first->focus_cm, 50, 1e-4);
  EXPECT_NEAR(middle->focus_cm, 75, 1e-4);
  EXPECT_NEAR(middle->lens_radius_cm, middle->focal_length_mm / 80, 1e-6);
}

TEST(Lens, RefusesWhatContradicts) {
  const std::string at = R"("eye": [0, -50, 0], )";
  const std::pair<std::string, std::string> wrong[] = {
      {R"("focal_length_mm": 50, "vertical_fov_deg": 30)", "/camera: expected at most one of"},
      {R"("orthographic_height_cm": 50, "vertical_fov_deg": 30)", "/camera: expected at most one of"},
      {R"("focal_length_mm": 2)", "/camera at frame 0: focal_length_mm: expected one that gives a vertical angle"},
      {R"("depth_of_field": {})", "/camera/depth_of_field: expected "},
      {R"("depth_of_field": {"f_number": 2, "radius_cm": 1})", "/camera/depth_of_field: expected "},
      {R"("depth_of_field": {"f_number": 2, "focus_cm": 3, "focus_point": [0, 0, 0]})",
       "/camera/depth_of_field: expected"},
      {R"("depth_of_field": {"f_number": 2, "focus_point": [0, -60, 0]})",
       "/camera at frame 0: depth_of_field/focus_point: expected a point before the camera, found one at -10 cm"},
      {R"("depth_of_field": {"f_number": 2, "blades": 2})", "/camera/depth_of_field/blades: expected a whole number"},
      {R"("depth_of_field": {"f_number": 2, "blade_rotation_deg": 2})", "/camera/depth_of_field/blade_rotation_deg"},
      {R"("orthographic_height_cm": 9, "depth_of_field": {"f_number": 2})",
       "/camera/depth_of_field/f_number: expected radius_cm"}};
  for (const auto& [keys, why] : wrong) {
    const auto camera = camera_of(at + keys, 300, 200);
    ASSERT_FALSE(camera) << keys;
    EXPECT_NE(camera.error().message().find(why), std::string::npos) << camera.error().message();
  }
}

}  // namespace
}  // namespace tress::scene
