// How surely a ray tells a mesh before a light from one that is flush with it, and where shadow rays end.
#pragma once

#include <glm/ext/vector_double3.hpp>
#include <glm/vec3.hpp>

#include "scene/model/scene.h"

namespace tress::integrate {

struct SceneSize {
  explicit SceneSize(const scene::Scene& scene);
  double coordinate_cm = 0;  ///< the largest, in absolute value, of strands and meshes
  double radius_cm = 0;      ///< the largest of a strand
};

/// A mesh that lies in a light's surface, or behind it by less than rounding, must not hide it; one before it must.
/// So whatever is met at a height above the light's surface of at most bound_cm() does not count: shadow rays end that
/// far above it, and the light is seen by a ray that meets a mesh there.
///
/// The bound, with h = 2^-24 (half a unit in the last place of 1), M and C the largest coordinates of the triangles
/// near the light and of the light, O that of the ray's start, t the way to the light, s the sum of the light's half
/// edges or its radius, r the largest radius of a strand, all in cm. Each line is a height, to first order in h:
///
///     sqrt(3) h M                        corners of the triangle, given in floats
///     sqrt(3) h C + 8 h s                middle of the light, given in floats, and its edges (made in 8 roundings)
///     sqrt(3) h (O + 8 r)                the ray's start, which Embree gets some radii further back (FiberScene)
///     h (3 t + 16 r)                     the ray's direction and its end, in floats
///     4 h (sqrt(3) (M + O) + 8 r)        corners taken from the start, and the product with the normal: three terms
///     3 h t                              the product of direction and normal
///     3 h longest^3 / (2 area)           the normal, a cross product of edges, which tilts the plane about a corner
///
/// in all h (8.7 (M + O) + 1.8 C + 8 s + 6 t + 62 r + slivers), 1e-4 cm in a scene of a meter. A division by the cosine
/// of grazing rays, which lengths along the ray would need, heights do not.
///
/// Where no mesh comes as near to the light as that the bound is 0: rays end at the light itself. So for distant
/// lights, which nothing is flush with. A light that moves has one bound, of wherever it goes while the shutter is
/// open. Immutable; any thread. Keeps no reference.
class LightClearance {
 public:
  LightClearance() = default;
  /// Looks at every triangle of the scene once.
  LightClearance(const scene::Light& light, const scene::Scene& scene, const SceneSize& of_scene);

  /// That of a light which moves, where it is at some time: of the shape that it has then.
  LightClearance at(const scene::LightShape& shape) const;

  /// Of a ray from `origin` (cm) that has `distance_cm` to the light.
  double bound_cm(const glm::vec3& origin, double distance_cm) const;

  struct Segment {
    glm::vec3 direction;  ///< unit
    float distance_cm;
  };
  /// The shadow ray in place of one from `origin` to the point of the light in a direction at a distance.
  Segment shadow(const glm::vec3& origin, const glm::vec3& direction, float distance_cm) const;

  /// Whether a ray that meets something at hit_cm sees the light that is at light_cm.
  bool is_seen(const glm::vec3& origin, const glm::vec3& direction, float light_cm, float hit_cm) const;

 private:
  void place(const scene::LightShape& shape);
  /// Above the surface, towards the side of `origin`; *normal gets the direction that it grows in.
  double height(const glm::dvec3& point, const glm::dvec3& origin, glm::dvec3* normal) const;

  bool is_sphere_ = false;
  glm::dvec3 center_{0.0}, normal_{0.0};
  double radius_cm_ = 0;
  double fixed_cm_ = 0;  ///< of the bound, what does not depend on the ray; 0: no mesh is near
};

}  // namespace tress::integrate
