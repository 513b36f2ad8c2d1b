#include "geometry/surface_hits.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace tress::geometry {

float largest_coordinate(const scene::Mesh& mesh) {
  float largest = 0;
  for (const glm::vec3& p : mesh.positions) {
    const float size = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    if (std::isfinite(size)) largest = std::max(largest, size);
  }
  return largest;
}

SurfacePoint surface_point(const scene::Mesh& mesh, std::uint32_t triangle, float second, float third,
                           float extent_cm) {
  const glm::uvec3& corner = mesh.triangles[triangle];
  const glm::dvec3 a = mesh.positions[corner.x], b = mesh.positions[corner.y], c = mesh.positions[corner.z];
  const glm::dvec3 ab = b - a, ac = c - a;
  const glm::dvec3 area = glm::cross(ab, ac);
  const double size = glm::length(area);
  SurfacePoint point;
  point.position = a + static_cast<double>(second) * ab + static_cast<double>(third) * ac;
  point.normal = size > 0 ? glm::vec3(area / size) : glm::vec3(0, 0, 1);
  // With half a unit in the last place h: the position and the ray's start are rounded to sqrt(3) h of a coordinate
  // each; the corners relative to the start, at most 2 sqrt(3) extents away, to h of that; the normal, a cross product
  // of two such edges, turns by 3 h longest^2 / size, which lifts the plane by that times `longest`. Twice the sum.
  constexpr float half_unit = std::numeric_limits<float>::epsilon() / 2;
  const double longest = std::max({glm::length(ab), glm::length(ac), glm::length(ac - ab)});
  const double sliver = size > 0 ? std::min(3 * longest * longest * longest / size, 1e3 * longest) : 0.0;
  point.offset_cm = 2 * half_unit * static_cast<float>(7 * double{extent_cm} + sliver);
  point.offset_cm = std::max(point.offset_cm, std::numeric_limits<float>::min());
  return point;
}

}  // namespace tress::geometry
