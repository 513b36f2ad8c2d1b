// Motion until the next frame: by hand, and as a layer of a picture.
#include "integrate/frame_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "integrate/renderer.h"
#include "integrate/white_fiber.h"

namespace tress::integrate {
namespace {

/// From 10 cm away, 100 pixels high under 90 degrees: 5 pixels a cm at the origin.
scene::Scene seen_from_ten_cm() {
  scene::Scene scene;
  scene.camera.eye = {0, -10, 0};
  scene.camera.vertical_fov_deg = 90;
  scene.image.width = 160;
  scene.image.height = 100;
  scene.next.emplace();
  scene.next->camera = scene.camera;
  return scene;
}

TEST(FrameMotion, ACameraThatGoesRightAndUpLeavesThingsToTheLeftAndBelow) {
  scene::Scene scene = seen_from_ten_cm();
  scene.next->camera.eye += glm::vec3(1, 0, 2);
  scene.next->camera.look_at += glm::vec3(1, 0, 2);
  const FrameMotion motion(scene);
  const glm::vec2 origin = motion.of_point({0, 0, 0}), far = motion.of_point({3, 10, -1});
  EXPECT_NEAR(origin.x, -5, 1e-4);
  EXPECT_NEAR(origin.y, -10, 1e-4);
  EXPECT_NEAR(far.x, -2.5, 1e-4);
  EXPECT_NEAR(far.y, -5, 1e-4);
  const glm::vec2 sky = motion.of_backdrop(glm::normalize(glm::vec3(0.2f, 1, 0.1f)));
  EXPECT_NEAR(sky.x, 0, 1e-4);
  EXPECT_NEAR(sky.y, 0, 1e-4);
}

// Turned to the left by the angle whose tangent is 1/2, what was in the middle is a quarter of the height to the right.
TEST(FrameMotion, ACameraThatTurnsMovesTheBackdropToo) {
  scene::Scene scene = seen_from_ten_cm();
  scene.next->camera.look_at = scene.camera.eye + glm::vec3(-0.5f, 1, 0);
  const FrameMotion motion(scene);
  EXPECT_NEAR(motion.of_backdrop({0, 1, 0}).x, 25, 1e-4);
  EXPECT_NEAR(motion.of_point({0, 0, 0}).x, 25, 1e-4);
  EXPECT_NEAR(motion.of_point({0, 0, 0}).y, 0, 1e-4);
}

// A quarter turn counter-clockwise from above about (1, 0): what is 1 cm before the axis goes 1 cm to its right, in the
// plane of the axis, where a cm is 5 pixels; lights and the backdrop rest.
TEST(FrameMotion, OnATurntableHairMovesAndLightsRest) {
  scene::Scene scene = seen_from_ten_cm();
  scene.next->turn = {std::acos(-1.0) / 2, {1, 0, 0}};
  const FrameMotion motion(scene);
  const double before = 50.0 / 9, after = 10;  // pixels right of the middle
  EXPECT_NEAR(motion.of_point({1, -1, 0}).x, after - before, 1e-4);
  EXPECT_NEAR(motion.of_point({1, -1, 0}).y, 0, 1e-4);
  EXPECT_NEAR(motion.of_point({1, 0, 3}).x, 0, 1e-4) << "on the axis";
  EXPECT_EQ(motion.of_light({1, -1, 0}), glm::vec2(0.0f));
  EXPECT_EQ(motion.of_backdrop({0, 1, 0}), glm::vec2(0.0f));
}

TEST(FrameMotion, WhatIsBehindTheNextCameraRests) {
  scene::Scene scene = seen_from_ten_cm();
  scene.next->camera.eye = {0, 20, 0};
  scene.next->camera.look_at = {0, 30, 0};
  EXPECT_EQ(FrameMotion(scene).of_point({1, 0, 0}), glm::vec2(0.0f));
}

// One path a pixel: where it met hair, the layer is the shift of the camera over the depth; elsewhere the backdrop's.
TEST(FrameMotion, IsALayerOfScenesThatMoveAndOfNoOthers) {
  scene::Scene scene = tangle(60, 48, 40);
  WhiteFiber model;
  const std::vector<fiber::FiberId> fibers{model.add_fiber(lossless_shares())};
  RenderOptions options;
  options.samples = 1;
  options.max_depth = 1;
  EXPECT_FALSE(render_with(scene, model, fibers, options).picture.find("forward.u"));
  scene.next.emplace();
  scene.next->camera = scene.camera;
  scene.next->camera.eye.x += 0.5f;
  scene.next->camera.look_at.x += 0.5f;
  const image::Picture picture = render_with(scene, model, fibers, options).picture;
  ASSERT_TRUE(picture.find("forward.u"));
  const std::vector<float>&u = picture.find("forward.u")->pixels, &v = picture.find("forward.v")->pixels,
        &z = picture.find("Z")->pixels, &coverage = picture.find("coverage")->pixels;
  const double pixels_at_one_cm =
      20 / std::tan(15 * std::acos(-1) / 180);  // half of 40 pixels under half of 30 degrees
  int met = 0;
  for (std::size_t i = 0; i < u.size(); ++i) {
    EXPECT_NEAR(v[i], 0, 1e-3) << i;
    if (coverage[i] == 0) {
      EXPECT_NEAR(u[i], 0, 1e-3) << i;
      continue;
    }
    ++met;
    // Z is along the ray, which is at most 20 degrees off the axis: the depth is between 0.94 of it and itself.
    const double of_z = 0.5 * pixels_at_one_cm / double{z[i]};
    EXPECT_LE(-u[i], of_z / 0.93);
    EXPECT_GE(-u[i], of_z * 0.999);
  }
  EXPECT_GT(met, 100);
}

}  // namespace
}  // namespace tress::integrate
