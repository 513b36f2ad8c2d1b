// The motion of points in the picture until the next frame.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "integrate/camera_projection.h"
#include "scene/model/scene.h"

namespace tress::integrate {

/// Motion in pixels, to the right and up, as Nuke's forward.u and forward.v: the place of a point in the picture of the
/// next frame minus that in this one. Immutable; thread-safe.
class FrameMotion {
 public:
  /// The next frame is Scene::next; without one, the camera and turntables rest.
  explicit FrameMotion(const scene::Scene& scene);
  /// The motion of points at this time of the shutter, [0, 1], in both frames.
  FrameMotion(const scene::Scene& scene, float time);

  /// Motion of a point of a groom or mesh. world: cm. way: its movement while the shutter is open, cm, which goes on
  /// until the next frame unless a turntable turns it. 0 if the point is behind the camera in either frame.
  glm::vec2 of_point(const glm::vec3& world, const glm::vec3& way = glm::vec3(0.0f)) const;
  /// Motion of a point of a light, which no turntable turns. way: movement of the light's middle while the shutter is
  /// open, cm.
  glm::vec2 of_light(const glm::vec3& world, const glm::vec3& way = glm::vec3(0.0f)) const;
  /// Motion of the infinitely distant environment in this direction. of_backdrop: it may turn. of_infinity: it rests.
  glm::vec2 of_backdrop(const glm::vec3& direction) const;
  glm::vec2 of_infinity(const glm::vec3& direction) const;

 private:
  FrameMotion(const scene::Scene& scene, const scene::Camera& now, const scene::Camera& next);

  CameraProjection now_, next_;
  glm::dvec3 eye_, next_eye_;
  scene::ObjectTurn turn_;
  scene::ObjectTurn backdrop_turn_;
  double ways_per_frame_ = 0;  ///< time from frame to frame over the time that the shutter is open
};

}  // namespace tress::integrate
