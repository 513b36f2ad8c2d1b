#include "integrate/frame_motion.h"

#include <optional>

namespace tress::integrate {
namespace {

const scene::Camera& next_camera(const scene::Scene& scene) { return scene.next ? scene.next->camera : scene.camera; }

/// Rows grow downwards, v upwards.
glm::vec2 moved(const std::optional<glm::dvec2>& from, const std::optional<glm::dvec2>& to) {
  if (!from || !to) return glm::vec2(0.0f);
  return {static_cast<float>(to->x - from->x), static_cast<float>(from->y - to->y)};
}

}  // namespace

FrameMotion::FrameMotion(const scene::Scene& scene)
    : now_(scene.camera, scene.image),
      next_(next_camera(scene), scene.image),
      eye_(scene.camera.eye),
      next_eye_(next_camera(scene).eye),
      turn_(scene.next ? scene.next->turn : scene::ObjectTurn{}) {}

glm::vec2 FrameMotion::of_point(const glm::vec3& world) const {
  const glm::dvec3 point(world);
  return moved(now_.pixel(point), next_.pixel(turn_.of(point)));
}

glm::vec2 FrameMotion::of_light(const glm::vec3& world) const {
  const glm::dvec3 point(world);
  return moved(now_.pixel(point), next_.pixel(point));
}

glm::vec2 FrameMotion::of_backdrop(const glm::vec3& direction) const {
  const glm::dvec3 way(direction);
  return moved(now_.pixel(eye_ + way), next_.pixel(next_eye_ + way));
}

}  // namespace tress::integrate
