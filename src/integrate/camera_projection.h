// Where points of the world are in the picture: the camera as matrices of an EXR header, and as a projection.
#pragma once

#include <array>
#include <glm/ext/vector_double2.hpp>
#include <glm/ext/vector_double3.hpp>
#include <glm/vec3.hpp>
#include <optional>

#include "image/picture.h"
#include "scene/model/scene.h"

namespace tress::integrate {

/// Unit, orthogonal: to the right and down in the picture, and into it. Where `up` is along the view, another axis
/// stands in.
struct CameraAxes {
  explicit CameraAxes(const scene::Camera& camera);
  glm::vec3 right, down, forward;
};

/// Immutable; any thread. Of the middle of the lens: depth of field does not move what is projected.
class CameraProjection {
 public:
  CameraProjection(const scene::Camera& camera, const scene::Image& image);

  /// From world, cm, to the camera: left-handed, x right, y up, z along the view. Row by row, for points as row vectors
  /// (p' = p M, translation in the last row): the worldToCamera of OpenEXR and RenderMan.
  std::array<double, 16> world_to_camera() const;
  /// From world to 0..1, x right, y down, over the whole image, after division by the last component: the worldToNDC of
  /// OpenEXR and RenderMan. There is no clipping; z is 1 - 0.1 cm / depth; of an
  /// orthographic camera, whose last component is 1, the depth less 0.1 cm.
  std::array<double, 16> world_to_ndc() const;

  /// Pixels of the whole image from its top left corner, x right, y down; pixel (0, 0) has its middle at (0.5, 0.5).
  /// Nothing of a point that is not before the camera.
  std::optional<glm::dvec2> pixel(const glm::dvec3& world) const;

  /// Of the picture at distance 1; orthographic: in cm.
  glm::dvec2 half_size() const { return {half_width_, half_height_}; }

 private:
  glm::dvec3 eye_, right_, up_, forward_;
  double half_width_, half_height_;  ///< of the picture, at depth 1
  bool orthographic_;
  double shift_x_, shift_y_;
  double width_, height_;  ///< pixels
};

/// The picture's matrices and the width of its screen.
void describe_camera(const scene::Camera& camera, const scene::Image& image, image::Picture* picture);

}  // namespace tress::integrate
