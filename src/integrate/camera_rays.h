// Rays of a pinhole camera through the pixels of an image, with an importance-sampled pixel filter.
#pragma once

#include <array>

#include "geometry/fiber_scene.h"
#include "scene/model/scene.h"

namespace tress::integrate {

/// Immutable; any thread.
class CameraRays {
 public:
  /// The vertical field of view spans image.height pixels. Where `up` is along the view, another axis stands in.
  CameraRays(const scene::Camera& camera, const scene::Image& image);

  /// Through pixel (x, y), y down from the top row, at an offset drawn from a tent of radius one pixel about its
  /// centre. u uniform in [0,1)^2; every ray has weight 1.
  geometry::Ray ray(int x, int y, const std::array<float, 2>& u) const;

 private:
  glm::vec3 eye_, corner_, right_, down_;  ///< corner: direction of the top left; right, down: steps of one pixel
};

}  // namespace tress::integrate
