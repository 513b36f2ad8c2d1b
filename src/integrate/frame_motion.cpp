#include "integrate/frame_motion.h"

#include <optional>
#include <vector>

#include "scene/model/camera.h"

namespace tress::integrate {
namespace {

const scene::Camera& next_camera(const scene::Scene& scene) { return scene.next ? scene.next->camera : scene.camera; }

scene::Camera during(const scene::Camera& still, const std::vector<scene::Camera>& moments, float time) {
  return moments.empty() ? still : scene::camera_during(moments, time);
}

/// Motion between two places in pixels. Rows grow downwards, but v grows upwards.
glm::vec2 moved(const std::optional<glm::dvec2>& from, const std::optional<glm::dvec2>& to) {
  if (!from || !to) return glm::vec2(0.0f);
  return {static_cast<float>(to->x - from->x), static_cast<float>(from->y - to->y)};
}

}  // namespace

FrameMotion::FrameMotion(const scene::Scene& scene, const scene::Camera& now, const scene::Camera& next)
    : now_(now, scene.image),
      next_(next, scene.image),
      eye_(now.eye),
      next_eye_(next.eye),
      turn_(scene.next ? scene.next->turn : scene::ObjectTurn{}),
      backdrop_turn_{scene.next ? scene.next->environment_turn_rad : 0},
      ways_per_frame_(scene.shutter.is_open() ? 1 / (scene.shutter.close - scene.shutter.open) : 0) {}

FrameMotion::FrameMotion(const scene::Scene& scene) : FrameMotion(scene, scene.camera, next_camera(scene)) {}

FrameMotion::FrameMotion(const scene::Scene& scene, float time)
    : FrameMotion(scene, during(scene.camera, scene.camera_moments, time),
                  scene.next ? during(scene.next->camera, scene.next->moments, time) : scene.camera) {}

glm::vec2 FrameMotion::of_point(const glm::vec3& world, const glm::vec3& way) const {
  const glm::dvec3 point(world);
  const glm::dvec3 next = turn_.turn_rad != 0 ? turn_.of(point) : point + ways_per_frame_ * glm::dvec3(way);
  return moved(now_.pixel(point), next_.pixel(next));
}

glm::vec2 FrameMotion::of_light(const glm::vec3& world, const glm::vec3& way) const {
  const glm::dvec3 point(world);
  return moved(now_.pixel(point), next_.pixel(point + ways_per_frame_ * glm::dvec3(way)));
}

glm::vec2 FrameMotion::of_backdrop(const glm::vec3& direction) const {
  if (backdrop_turn_.turn_rad == 0) return of_infinity(direction);
  const glm::dvec3 way(direction);
  return moved(now_.pixel(eye_ + way), next_.pixel(next_eye_ + backdrop_turn_.of(way)));
}

glm::vec2 FrameMotion::of_infinity(const glm::vec3& direction) const {
  const glm::dvec3 way(direction);
  return moved(now_.pixel(eye_ + way), next_.pixel(next_eye_ + way));
}

}  // namespace tress::integrate
