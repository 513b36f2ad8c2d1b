// The camera as the matrices of an EXR header and as a projection, against its rays and by hand.
#include "integrate/camera_projection.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "integrate/camera_rays.h"

namespace tress::integrate {
namespace {

/// p M of a point as a row vector.
std::array<double, 4> times(const glm::dvec3& p, const std::array<double, 16>& m) {
  std::array<double, 4> out{};
  for (std::size_t c = 0; c < 4; ++c) out[c] = p.x * m[c] + p.y * m[4 + c] + p.z * m[8 + c] + m[12 + c];
  return out;
}

scene::Camera tilted() {
  scene::Camera camera;
  camera.eye = {12, -31, 7};
  camera.look_at = {-2, 1, 4};
  camera.up = {0.2f, 0.1f, 1};
  camera.vertical_fov_deg = 41;
  return camera;
}

// By hand: from y = -10 with z up, x is to the right, z up and y into the picture.
TEST(CameraProjection, ACameraOnMinusYSeesXToTheRightZUpAndYInDepth) {
  scene::Camera camera;
  camera.eye = {0, -10, 0};
  camera.vertical_fov_deg = 90;
  scene::Image image;
  image.width = 200;
  image.height = 100;
  const CameraProjection projection(camera, image);
  const std::array<double, 4> seen = times({1, 0, 2}, projection.world_to_camera());
  const std::array<double, 4> expected{1, 2, 10, 1};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(seen[i], expected[i], 1e-6);
  // At depth 10 the picture is 40 cm wide and 20 cm high.
  const auto pixel = projection.pixel({10, 0, 5});
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->x, 150, 1e-4);
  EXPECT_NEAR(pixel->y, 25, 1e-4);
  EXPECT_FALSE(projection.pixel({0, -10, 0}));
  EXPECT_FALSE(projection.pixel({0, -11, 0}));
}

TEST(CameraProjection, PointsOnARayThroughAPixelAreProjectedThere) {
  scene::Image image;
  image.width = 96;
  image.height = 54;
  const CameraProjection projection(tilted(), image);
  const CameraRays rays(tilted(), image);
  const std::array<double, 16> ndc = projection.world_to_ndc(), camera = projection.world_to_camera();
  for (const int x : {0, 17, 95})
    for (const int y : {0, 30, 53})
      for (const double distance : {0.5, 40.0, 9000.0}) {
        const geometry::Ray ray = rays.ray(x, y, {0.5f, 0.5f});  // through the pixel's middle
        const glm::dvec3 point = glm::dvec3(ray.origin) + distance * glm::dvec3(ray.direction);
        const auto pixel = projection.pixel(point);
        ASSERT_TRUE(pixel);
        EXPECT_NEAR(pixel->x, x + 0.5, 1e-3);  // rays are floats: a direction is good to 1e-7 of a picture of 96 pixels
        EXPECT_NEAR(pixel->y, y + 0.5, 1e-3);
        const std::array<double, 4> in_ndc = times(point, ndc), in_camera = times(point, camera);
        EXPECT_NEAR(in_ndc[0] / in_ndc[3], pixel->x / image.width, 1e-9);
        EXPECT_NEAR(in_ndc[1] / in_ndc[3], pixel->y / image.height, 1e-9);
        EXPECT_NEAR(in_ndc[2] / in_ndc[3], 1 - 0.1 / in_camera[2], 1e-6);
        EXPECT_NEAR(std::hypot(in_camera[0], in_camera[1], in_camera[2]), distance, 1e-5 * distance);
      }
}

TEST(CameraProjection, FollowsShiftedAndOrthographicCamerasToo) {
  scene::Image image;
  image.width = 96;
  image.height = 54;
  for (const float height : {0.0f, 30.0f}) {
    scene::Camera camera = tilted();
    camera.orthographic_height_cm = height;
    camera.shift_x = 0.25f;
    camera.shift_y = -0.5f;
    const CameraProjection projection(camera, image);
    const CameraRays rays(camera, image);
    // The view is moved: what was in its middle is now a quarter to the left of it, and half a picture higher.
    const auto middle = projection.pixel(camera.look_at);
    EXPECT_NEAR(middle->x, 0.25 * 96, 1e-4);
    EXPECT_NEAR(middle->y, 0, 1e-4);
    const std::array<double, 16> ndc = projection.world_to_ndc();
    for (const int x : {0, 17, 95})
      for (const int y : {0, 30, 53}) {
        const geometry::Ray ray = rays.ray(x, y, {0.5f, 0.5f});
        const glm::dvec3 point = glm::dvec3(ray.origin) + 40.0 * glm::dvec3(ray.direction);
        const auto pixel = projection.pixel(point);
        ASSERT_TRUE(pixel);
        EXPECT_NEAR(pixel->x, x + 0.5, 1e-3);
        EXPECT_NEAR(pixel->y, y + 0.5, 1e-3);
        const std::array<double, 4> in_ndc = times(point, ndc);
        EXPECT_NEAR(in_ndc[0] / in_ndc[3], pixel->x / image.width, 1e-9);
        EXPECT_NEAR(in_ndc[1] / in_ndc[3], pixel->y / image.height, 1e-9);
        if (height > 0) {
          EXPECT_NEAR(in_ndc[2] / in_ndc[3], 40 - 0.1, 1e-4) << "depth less 0.1 cm";
        }
      }
  }
}

// OpenEXR: the camera's space is left-handed; the world here is right-handed.
TEST(CameraProjection, TheCamerasSpaceIsLeftHandedAndKeepsLengths) {
  const std::array<double, 16> m = CameraProjection(tilted(), {}).world_to_camera();
  const glm::dvec3 a(m[0], m[1], m[2]), b(m[4], m[5], m[6]), c(m[8], m[9], m[10]);
  EXPECT_NEAR(glm::dot(glm::cross(a, b), c), -1, 1e-6);
  EXPECT_NEAR(glm::dot(a, b), 0, 1e-6);
  EXPECT_NEAR(glm::length(b), 1, 1e-6);
}

TEST(CameraProjection, APictureGetsTheMatricesAndTheWidthOfItsScreen) {
  scene::Camera camera;
  camera.vertical_fov_deg = 90;
  scene::Image image;
  image.width = 300;
  image.height = 100;
  camera.shift_x = 0.5f;
  camera.shift_y = 0.25f;
  image::Picture picture;
  describe_camera(camera, image, &picture);
  EXPECT_NEAR(picture.screen_width, 6, 1e-5);
  EXPECT_NEAR(picture.screen_center[0], 3, 1e-5);
  EXPECT_NEAR(picture.screen_center[1], 0.5, 1e-5);
  EXPECT_EQ(picture.matrices.count("worldToCamera"), 1u);
  EXPECT_NEAR(picture.matrices.at("worldToNDC")[15], CameraProjection(camera, image).world_to_ndc()[15], 1e-5);
}

// A camera far from 0 counts from an origin near it: its matrices take points of the world all the same.
TEST(CameraProjection, MatricesAreForPointsCountedFromZero) {
  scene::Camera camera;
  camera.eye = {3, -20, 5};
  camera.look_at = {0, 1, 2};
  const scene::Image image;
  const glm::dvec3 origin(4000, -8000, 16000);
  image::Picture near, far;
  describe_camera(camera, image, &near);
  describe_camera(camera, image, &far, origin);
  const glm::dvec4 point(1, 2, 3, 1), moved = point + glm::dvec4(origin, 0);
  for (const char* name : {"worldToCamera", "worldToNDC"})
    for (std::size_t column = 0; column < 4; ++column) {
      double a = 0, b = 0;
      for (int row = 0; row < 4; ++row) {
        a += point[row] * double{near.matrices.at(name)[4 * static_cast<std::size_t>(row) + column]};
        b += moved[row] * double{far.matrices.at(name)[4 * static_cast<std::size_t>(row) + column]};
      }
      EXPECT_NEAR(a, b, 0.02) << name << " " << column << ": floats of 16000 are 0.001 apart, times 5 terms and scale";
    }
}

}  // namespace
}  // namespace tress::integrate
