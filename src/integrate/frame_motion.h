// How far what is seen moves in the picture until the next frame.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "integrate/camera_projection.h"
#include "scene/model/scene.h"

namespace tress::integrate {

/// Pixels to the right and up from this frame to the next, as Nuke's forward.u and forward.v: the place of a point in
/// the picture of the next frame less that in this one. Immutable; any thread.
class FrameMotion {
 public:
  /// Of a scene whose next frame is known (Scene::next); of any other everything rests.
  explicit FrameMotion(const scene::Scene& scene);
  /// While the shutter is open, at this time of it in this frame and in the next.
  FrameMotion(const scene::Scene& scene, float time);

  /// Of a point of a groom or mesh, cm, that goes this way while the shutter is open, and goes on like that until the
  /// next frame unless a turntable turns it. 0 where it is behind the camera in either frame.
  glm::vec2 of_point(const glm::vec3& world, const glm::vec3& way = glm::vec3(0.0f)) const;
  /// Of one of a light, which no turntable turns; its middle goes that way while the shutter is open.
  glm::vec2 of_light(const glm::vec3& world, const glm::vec3& way = glm::vec3(0.0f)) const;
  /// Of what is infinitely far away in this direction: the environment, which may turn, or what rests.
  glm::vec2 of_backdrop(const glm::vec3& direction) const;
  glm::vec2 of_infinity(const glm::vec3& direction) const;

 private:
  FrameMotion(const scene::Scene& scene, const scene::Camera& now, const scene::Camera& next);

  CameraProjection now_, next_;
  glm::dvec3 eye_, next_eye_;
  scene::ObjectTurn turn_;
  scene::ObjectTurn backdrop_turn_;
  double ways_per_frame_ = 0;  ///< how often the shutter could be open in the time from frame to frame
};

}  // namespace tress::integrate
