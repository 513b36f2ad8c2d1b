// Rays of a pinhole camera through the pixels of an image, with an importance-sampled pixel filter.
#pragma once

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "geometry/fiber_scene.h"
#include "integrate/camera_projection.h"
#include "scene/model/scene.h"

namespace tress::integrate {

/// Immutable; any thread.
class CameraRays {
 public:
  /// The vertical field of view spans image.height pixels.
  CameraRays(const scene::Camera& camera, const scene::Image& image);

  /// Through pixel (x, y), y down from the top row, at an offset drawn from a tent of radius one pixel about its
  /// centre. u uniform in [0,1)^2; every ray has weight 1.
  geometry::Ray ray(int x, int y, const std::array<float, 2>& u) const;

  /// Angle between the rays of neighbouring pixels, about a ray of this direction.
  float pixel_rad(const glm::vec3& direction) const { return pixel_ * glm::dot(direction, forward_); }

 private:
  /// Inverse CDF of the tent 1 - |x| on [-1, 1].
  static float tent(float u) { return u < 0.5f ? std::sqrt(2 * u) - 1 : 1 - std::sqrt(2 - 2 * u); }

  /// corner: direction of the top left; right, down: steps of one pixel where `forward`, unit, ends.
  glm::vec3 eye_, forward_, corner_, right_, down_;
  float pixel_;  ///< length of such a step
};

inline CameraRays::CameraRays(const scene::Camera& camera, const scene::Image& image)
    : eye_(camera.eye), forward_(CameraAxes(camera).forward) {
  const CameraAxes axes(camera);
  const glm::vec3 &forward = axes.forward, &right = axes.right, &down = axes.down;
  const float half_height = std::tan(camera.vertical_fov_deg * std::numbers::pi_v<float> / 360);
  pixel_ = 2 * half_height / static_cast<float>(image.height);
  right_ = pixel_ * right;
  down_ = pixel_ * down;
  corner_ = forward - 0.5f * static_cast<float>(image.width) * right_ - 0.5f * static_cast<float>(image.height) * down_;
}

inline geometry::Ray CameraRays::ray(int x, int y, const std::array<float, 2>& u) const {
  const float column = static_cast<float>(x) + 0.5f + tent(u[0]);
  const float row = static_cast<float>(y) + 0.5f + tent(u[1]);
  return {eye_, glm::normalize(corner_ + column * right_ + row * down_)};
}

}  // namespace tress::integrate
