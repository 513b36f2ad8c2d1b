// Objects that only some rays meet.
#include <gtest/gtest.h>

#include <array>
#include <optional>

#include "geometry/straight_strands.h"

namespace tress::geometry {
namespace {

/// Along y: a strand at 0, one of another groom at 3, a wall at 6.
scene::Scene two_strands_and_a_wall() {
  scene::Scene scene = straight_scene({{{0, 0, 4}, {0, 0, -4}, 0.5f, 0.5f, 1}}, true);
  scene.grooms.push_back(scene.grooms[0]);
  for (glm::vec3& point : scene.grooms[1].points) point.y += 3;
  scene.meshes.resize(1);
  scene.meshes[0].positions = {{-4, 6, -4}, {4, 6, -4}, {0, 6, 4}};
  scene.meshes[0].triangles = {{0, 1, 2}};
  return scene;
}

/// The first object that a ray along y meets: 0 and 1 are grooms, 2 is the wall, -1 is nothing.
int met(const FiberScene& fibers, bool from_camera, const scene::ObjectMarks* passed = nullptr) {
  Ray ray{.origin = {0.1f, -5, 0.3f}, .direction = {0, 1, 0}, .from_camera = from_camera, .passed = passed};
  const std::optional<Hit> hit = fibers.intersect(ray);
  if (fibers.has_presence()) {
    ray.drawn = 0.5f;
    const std::optional<Hit> drawn = fibers.intersect(ray);
    EXPECT_EQ(hit.has_value(), drawn.has_value());
    if (hit && drawn) {
      EXPECT_EQ(hit->distance_cm, drawn->distance_cm);
    }
  }
  return !hit ? -1 : hit->is_surface ? 2 : static_cast<int>(hit->groom);
}

bool is_shadowed(const FiberScene& fibers, float distance_cm) {
  return fibers.occluded({.origin = {0.1f, -5, 0.3f}, .direction = {0, 1, 0}}, distance_cm);
}

/// presence: of the strands, 1 in the second round, which takes the other way through the filter.
TEST(Visibility, LeavesOutObjectsForRaysOfOneKindOnly) {
  for (const bool sparse : {false, true}) {
    scene::Scene scene = two_strands_and_a_wall();
    if (sparse)
      for (scene::Groom& groom : scene.grooms) groom.presence = {1};
    scene.grooms[0].visibility = {.camera = false, .shadow = true, .indirect = true};
    scene.grooms[1].visibility = {.camera = true, .shadow = false, .indirect = true};
    {
      const FiberScene fibers(scene);
      EXPECT_EQ(met(fibers, true), 1);
      EXPECT_EQ(met(fibers, false), 0);
      EXPECT_TRUE(is_shadowed(fibers, 6));
    }
    scene.grooms[0].visibility = {.camera = true, .shadow = false, .indirect = false};
    {
      const FiberScene fibers(scene);
      EXPECT_EQ(met(fibers, true), 0);
      EXPECT_EQ(met(fibers, false), 1);
      EXPECT_FALSE(is_shadowed(fibers, 10));
      EXPECT_TRUE(is_shadowed(fibers, 12)) << "the wall";
    }
    scene.grooms[0].visibility = scene.grooms[1].visibility = {.camera = false, .shadow = false, .indirect = false};
    scene.meshes[0].visibility = {.camera = false, .shadow = false, .indirect = true};
    const FiberScene fibers(scene);
    EXPECT_EQ(met(fibers, true), -1);
    EXPECT_EQ(met(fibers, false), 2);
    EXPECT_FALSE(is_shadowed(fibers, 12));
  }
}

TEST(Visibility, ARayThatSaysWhatItPassesMeetsAllElse) {
  scene::Scene scene = two_strands_and_a_wall();
  scene.grooms[1].visibility = {.camera = false, .shadow = false, .indirect = false};
  const FiberScene fibers(scene);
  const std::array<scene::ObjectMarks, 4> marks{{{}, {1, 0, 0}, {1, 1, 0}, {1, 1, 1}}};
  const std::array<int, 4> expected{0, 1, 2, -1};
  for (std::size_t i = 0; i < marks.size(); ++i) {
    EXPECT_EQ(met(fibers, false, &marks[i]), expected[i]);
    EXPECT_EQ(met(fibers, true, &marks[i]), expected[i]);
    EXPECT_EQ(fibers.occluded({.origin = {0.1f, -5, 0.3f}, .direction = {0, 1, 0}, .passed = &marks[i]}), i < 3);
  }
}

}  // namespace
}  // namespace tress::geometry
