// The precision with which a ray separates a mesh in front of a light from one flush with it, and where shadow rays
// end.
#pragma once

#include <glm/ext/vector_double3.hpp>
#include <glm/vec3.hpp>

#include "scene/model/scene.h"

namespace tress::integrate {

struct SceneSize {
  explicit SceneSize(const scene::Scene& scene);
  double coordinate_cm = 0;  ///< largest absolute coordinate of strands and meshes
  double radius_cm = 0;      ///< largest radius of a strand
};

/// A mesh that lies in a light's surface, up to rounding, must not hide the light; a mesh in front of it must. So hits
/// at a height of at most bound_cm() above the light's surface do not count: shadow rays end at that height, and a ray
/// that meets a mesh below it still sees the light.
///
/// The bound, with h = 2^-24 (half a unit in the last place of 1), M and C the largest coordinates of the triangles
/// near the light and of the light, and O that of the ray's start. t is the distance to the light, s the sum of the
/// light's half edges or its radius, r the largest radius of a strand, all in cm. Each line is a height, to first order
/// in h:
///
///     sqrt(3) h M                        corners of the triangle, given in floats
///     sqrt(3) h C + 8 h s                middle of the light, given in floats, and its edges (made in 8 roundings)
///     sqrt(3) h (O + 8 r)                the ray's start, some radii further back for Embree (FiberScene)
///     h (3 t + 16 r)                     the ray's direction and its end, in floats
///     4 h (sqrt(3) (M + O) + 8 r)        corners taken from the start, and the product with the normal: three terms
///     3 h t                              the product of direction and normal
///     3 h longest^3 / (2 area)           the normal, a cross product of edges, which tilts the plane about a corner
///
/// The sum is h (8.7 (M + O) + 1.8 C + 8 s + 6 t + 62 r + slivers), about 1e-4 cm in a scene of a meter. Lengths along
/// the ray would need a division by the cosine, which is small for grazing rays; heights do not.
///
/// If no mesh comes that near to the light, the bound is 0 and rays end at the light itself. It is always 0 for distant
/// lights. A light that moves has one bound for all places that it passes while the shutter is open. Immutable;
/// thread-safe. Keeps no reference.
class LightClearance {
 public:
  LightClearance() = default;
  /// Visits every triangle of the scene once.
  LightClearance(const scene::Light& light, const scene::Scene& scene, const SceneSize& of_scene);

  /// The clearance of a moving light at the time when it has this shape.
  LightClearance at(const scene::LightShape& shape) const;

  /// The bound for a ray from `origin` (cm) to the light at `distance_cm`.
  double bound_cm(const glm::vec3& origin, double distance_cm) const;

  struct Segment {
    glm::vec3 direction;  ///< unit
    float distance_cm;
  };
  /// The shadow ray to use for the ray from `origin` to the point of the light in this direction at this distance.
  Segment shadow(const glm::vec3& origin, const glm::vec3& direction, float distance_cm) const;

  /// Whether a ray that meets something at hit_cm still sees the light at light_cm.
  bool is_seen(const glm::vec3& origin, const glm::vec3& direction, float light_cm, float hit_cm) const;

 private:
  void place(const scene::LightShape& shape);
  /// Height of a point above the surface, on the side of `origin`. *normal gets the direction in which it grows.
  double height(const glm::dvec3& point, const glm::dvec3& origin, glm::dvec3* normal) const;

  bool is_sphere_ = false;
  glm::dvec3 center_{0.0}, normal_{0.0};
  double radius_cm_ = 0;
  double fixed_cm_ = 0;  ///< part of the bound that does not depend on the ray; 0 if no mesh is near
};

}  // namespace tress::integrate
