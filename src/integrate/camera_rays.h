// Rays of a pinhole or thin-lens camera through the pixels of an image, with an importance-sampled pixel filter.
#pragma once

#include <algorithm>
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
  /// The vertical field of view, or the height of an orthographic camera, spans image.height pixels.
  CameraRays(const scene::Camera& camera, const scene::Image& image);

  /// A ray through pixel (x, y), y down from the top row, at an offset drawn from a tent of radius one pixel about its
  /// centre. With a lens, the ray starts at a point drawn uniformly on the lens and goes to the point of the focal
  /// plane that the ray through the lens's middle meets. u, u_lens: uniform in [0,1)^2. Every ray has weight 1.
  geometry::Ray ray(int x, int y, const std::array<float, 2>& u, const std::array<float, 2>& u_lens = {0, 0}) const;

  /// Whether ray() uses u_lens.
  bool has_lens() const { return lens_radius_cm_ > 0; }

  /// Angle between the rays of neighbouring pixels near a ray of this direction; 0 for an orthographic camera.
  float pixel_rad(const glm::vec3& direction) const {
    return orthographic_ ? 0 : pixel_ * glm::dot(direction, forward_);
  }
  /// Width of a pixel, cm, at this distance along a ray of this direction.
  float pixel_cm(const glm::vec3& direction, float distance_cm) const {
    return orthographic_ ? pixel_ : pixel_rad(direction) * distance_cm;
  }

 private:
  /// Inverse CDF of the tent 1 - |x| on [-1, 1].
  static float tent(float u) { return u < 0.5f ? std::sqrt(2 * u) - 1 : 1 - std::sqrt(2 - 2 * u); }

  /// A uniform point on the lens, to the right and up: on the unit disk by concentric squares (Shirley and Chiu 1997),
  /// or on the regular polygon in it.
  std::array<float, 2> on_lens(const std::array<float, 2>& u) const;

  /// corner: from the eye to the top left of the picture at distance 1. right, down: steps of one pixel there. All are
  /// in cm for an orthographic camera.
  glm::vec3 eye_, forward_, corner_, right_, down_;
  float pixel_;  ///< length of a step of one pixel
  bool orthographic_;
  float lens_radius_cm_, focus_cm_;
  int blades_;
  float blade_rotation_rad_;
};

inline CameraRays::CameraRays(const scene::Camera& camera, const scene::Image& image)
    : eye_(camera.eye),
      forward_(CameraAxes(camera).forward),
      orthographic_(camera.orthographic_height_cm > 0),
      lens_radius_cm_(camera.lens_radius_cm),
      focus_cm_(camera.focus_cm),
      blades_(camera.blades),
      blade_rotation_rad_(camera.blade_rotation_rad) {
  const CameraAxes axes(camera);
  const glm::vec3 &forward = axes.forward, &right = axes.right, &down = axes.down;
  const float half_height = orthographic_ ? camera.orthographic_height_cm / 2
                                          : std::tan(camera.vertical_fov_deg * std::numbers::pi_v<float> / 360);
  pixel_ = 2 * half_height / static_cast<float>(image.height);
  right_ = pixel_ * right;
  down_ = pixel_ * down;
  corner_ = forward - (0.5f - camera.shift_x) * static_cast<float>(image.width) * right_ -
            (0.5f + camera.shift_y) * static_cast<float>(image.height) * down_;
}

inline std::array<float, 2> CameraRays::on_lens(const std::array<float, 2>& u) const {
  constexpr float pi = std::numbers::pi_v<float>;
  if (blades_ >= 3) {
    // Draws a triangle between the middle and two corners, and a uniform point in it.
    const float scaled = u[0] * static_cast<float>(blades_);
    const float blade = std::min(std::floor(scaled), static_cast<float>(blades_ - 1));
    const float out = std::sqrt(scaled - blade), along = out * u[1];
    const float step = 2 * pi / static_cast<float>(blades_), first = blade_rotation_rad_ + blade * step;
    return {(out - along) * std::cos(first) + along * std::cos(first + step),
            (out - along) * std::sin(first) + along * std::sin(first + step)};
  }
  const float a = 2 * u[0] - 1, b = 2 * u[1] - 1;
  if (a == 0 && b == 0) return {0, 0};
  const bool wide = std::abs(a) > std::abs(b);
  const float radius = wide ? a : b, angle = wide ? pi / 4 * (b / a) : pi / 2 - pi / 4 * (a / b);
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

inline geometry::Ray CameraRays::ray(int x, int y, const std::array<float, 2>& u,
                                     const std::array<float, 2>& u_lens) const {
  const float column = static_cast<float>(x) + 0.5f + tent(u[0]);
  const float row = static_cast<float>(y) + 0.5f + tent(u[1]);
  const glm::vec3 through = corner_ + column * right_ + row * down_;
  geometry::Ray ray{eye_, forward_};
  ray.from_camera = true;
  if (orthographic_)
    ray.origin += through - forward_;
  else
    ray.direction = glm::normalize(through);
  if (!has_lens()) return ray;
  const std::array<float, 2> lens = on_lens(u_lens);
  const glm::vec3 aside = (lens_radius_cm_ / pixel_) * (lens[0] * right_ - lens[1] * down_);
  ray.direction = glm::normalize(focus_cm_ * (orthographic_ ? forward_ : through) - aside);
  ray.origin += aside;
  return ray;
}

}  // namespace tress::integrate
