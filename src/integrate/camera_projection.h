// The camera as the matrices of an EXR header, and as the projection of points of the world to pixels.
#pragma once

#include <array>
#include <glm/ext/vector_double2.hpp>
#include <glm/ext/vector_double3.hpp>
#include <glm/vec3.hpp>
#include <optional>

#include "image/picture.h"
#include "scene/model/scene.h"

namespace tress::integrate {

/// Orthogonal unit vectors: to the right and down in the picture, and into it. If `up` is along the view, another axis
/// replaces it.
struct CameraAxes {
  explicit CameraAxes(const scene::Camera& camera);
  glm::vec3 right, down, forward;
};

/// Projects through the middle of the lens, so depth of field does not move points. Immutable; thread-safe.
class CameraProjection {
 public:
  CameraProjection(const scene::Camera& camera, const scene::Image& image);

  /// The matrix from world, cm, to the camera: left-handed, x right, y up, z along the view. It is stored row by row
  /// for row vectors (p' = p M, translation in the last row), as the worldToCamera of OpenEXR and RenderMan.
  std::array<double, 16> world_to_camera() const;
  /// The matrix from world to 0..1 over the whole image, x right, y down, after division by the last component, as the
  /// worldToNDC of OpenEXR and RenderMan. There is no clipping. z is 1 - 0.1 cm / depth; for an orthographic camera,
  /// whose last component is 1, it is the depth minus 0.1 cm.
  std::array<double, 16> world_to_ndc() const;

  /// The point in pixels of the whole image, from its top left corner, x right, y down; the middle of pixel (0, 0) is
  /// at (0.5, 0.5). Empty for a point that is not in front of the camera.
  std::optional<glm::dvec2> pixel(const glm::dvec3& world) const;

  /// Half the width and height of the picture at distance 1; in cm for an orthographic camera.
  glm::dvec2 half_size() const { return {half_width_, half_height_}; }

 private:
  glm::dvec3 eye_, right_, up_, forward_;
  double half_width_, half_height_;  ///< as half_size()
  bool orthographic_;
  double shift_x_, shift_y_;
  double width_, height_;  ///< pixels
};

/// Sets the matrices of the picture and the width of its screen.
/// origin: as Scene::origin; the matrices are for points counted from 0.
void describe_camera(const scene::Camera& camera, const scene::Image& image, image::Picture* picture,
                     const glm::dvec3& origin = glm::dvec3(0.0));

}  // namespace tress::integrate
