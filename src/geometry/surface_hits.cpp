#include "geometry/surface_hits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>

namespace tress::geometry {
namespace {

using Points = std::vector<glm::vec3>;

/// Values of the mesh at a time of the shutter, linear between two moments.
class AtTime {
 public:
  AtTime(const scene::Mesh& mesh, float time, Points scene::Mesh::* first, Points scene::MeshMoment::* later)
      : before_(&(mesh.*first)) {
    if (mesh.later.empty()) return;
    const scene::BetweenMoments at(time, 1 + mesh.later.size());
    if (at.before > 0) before_ = &(mesh.later[at.before - 1].*later);
    after_ = &(mesh.later[at.before].*later);
    share_ = at.share;
  }
  glm::dvec3 operator[](std::uint32_t index) const {
    const glm::dvec3 before((*before_)[index]);
    if (after_ == nullptr) return before;
    return before + double{share_} * (glm::dvec3((*after_)[index]) - before);
  }

 private:
  const Points *before_, *after_ = nullptr;
  float share_ = 0;
};

/// The normals at the corners of a triangle, of any length and on either side; empty if one has none.
std::optional<std::array<glm::vec3, 3>> corner_normals(const scene::Mesh& mesh, std::uint32_t triangle, float time) {
  if (mesh.corner_normals.empty()) return std::nullopt;
  const glm::uvec3 corner = mesh.corner_normals[triangle];
  if (corner.x == scene::no_normal || corner.y == scene::no_normal || corner.z == scene::no_normal) return std::nullopt;
  const AtTime normals(mesh, time, &scene::Mesh::normals, &scene::MeshMoment::normals);
  return std::array<glm::vec3, 3>{normals[corner.x], normals[corner.y], normals[corner.z]};
}

}  // namespace

float largest_coordinate(const scene::Mesh& mesh) {
  float largest = 0;
  const auto include = [&](const Points& points) {
    for (const glm::vec3& p : points) {
      const float size = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
      if (std::isfinite(size)) largest = std::max(largest, size);
    }
  };
  include(mesh.positions);
  for (const scene::MeshMoment& moment : mesh.later) include(moment.positions);
  return largest;
}

SurfacePoint surface_point(const scene::Mesh& mesh, std::uint32_t triangle, float second, float third, float extent_cm,
                           float time) {
  const glm::uvec3& corner = mesh.triangles[triangle];
  const AtTime positions(mesh, time, &scene::Mesh::positions, &scene::MeshMoment::positions);
  const glm::dvec3 a = positions[corner.x], b = positions[corner.y], c = positions[corner.z];
  const glm::dvec3 ab = b - a, ac = c - a;
  const glm::dvec3 area = glm::cross(ab, ac);
  const double size = glm::length(area);
  SurfacePoint point;
  point.position = a + static_cast<double>(second) * ab + static_cast<double>(third) * ac;
  point.normal = size > 0 ? glm::vec3(area / size) : glm::vec3(0, 0, 1);
  // Let h be half a unit in the last place. The position and the ray's start are rounded to sqrt(3) h of a coordinate
  // each. The corners relative to the start, at most 2 sqrt(3) extents away, are rounded to h of that. The normal, a
  // cross product of two such edges, turns by 3 h longest^2 / size, which lifts the plane by that times `longest`.
  // Embree interpolates moving corners in floats: two products, their sum and the share itself make 4 h of a
  // coordinate, sqrt(3) times that in space. The bound is twice the sum.
  constexpr float half_unit = std::numeric_limits<float>::epsilon() / 2;
  const double longest = std::max({glm::length(ab), glm::length(ac), glm::length(ac - ab)});
  const double sliver = size > 0 ? std::min(3 * longest * longest * longest / size, 1e3 * longest) : 0.0;
  const double roundings = mesh.later.empty() ? 7 : 14;
  point.offset_cm = 2 * half_unit * static_cast<float>(roundings * double{extent_cm} + sliver);
  point.offset_cm = std::max(point.offset_cm, std::numeric_limits<float>::min());
  return point;
}

glm::vec3 surface_way(const scene::Mesh& mesh, std::uint32_t triangle, float second, float third) {
  const glm::uvec3& corner = mesh.triangles[triangle];
  const Points& last = mesh.later.back().positions;
  const auto way = [&](std::uint32_t index) { return last[index] - mesh.positions[index]; };
  return (1 - second - third) * way(corner.x) + second * way(corner.y) + third * way(corner.z);
}

glm::vec3 shading_normal(const scene::Mesh& mesh, std::uint32_t triangle, float second, float third,
                         const glm::vec3& normal, const glm::vec3& ray_direction, float time) {
  const std::optional<std::array<glm::vec3, 3>> normals = corner_normals(mesh, triangle, time);
  if (!normals) return normal;
  const auto& [a, b, c] = *normals;
  if (a == glm::vec3(0.0f) || b == glm::vec3(0.0f) || c == glm::vec3(0.0f)) return normal;
  glm::vec3 between = (1 - second - third) * a + second * b + third * c;
  const float length = glm::length(between);
  constexpr float shortest = 1e-3f, grazing = 0.01f;
  if (!(length > shortest)) return normal;
  between /= length;
  // Files wind their faces either way, so the side is that of the ray; a normal that deviates so far from the face is
  // not valid for it.
  const float with_face = glm::dot(between, normal);
  if (std::abs(with_face) < grazing) return normal;
  if (with_face < 0) between = -between;
  const float towards = -glm::dot(between, ray_direction);
  return towards >= grazing ? between : glm::normalize(between + (towards - grazing) * ray_direction);
}

glm::vec3 way_to_smooth(const scene::Mesh& mesh, std::uint32_t triangle, float second, float third,
                        const glm::vec3& normal, float time) {
  const std::optional<std::array<glm::vec3, 3>> normals = corner_normals(mesh, triangle, time);
  if (!normals) return glm::vec3(0.0f);
  const AtTime positions(mesh, time, &scene::Mesh::positions, &scene::MeshMoment::positions);
  const glm::uvec3& corner = mesh.triangles[triangle];
  const std::array<glm::vec3, 3> corners{positions[corner.x], positions[corner.y], positions[corner.z]};
  const std::array<float, 3> weight{1 - second - third, second, third};
  const glm::vec3 point = weight[0] * corners[0] + weight[1] * corners[1] + weight[2] * corners[2];
  glm::vec3 way(0.0f);
  for (std::size_t i = 0; i < 3; ++i) {
    const float length = glm::length((*normals)[i]);
    if (!(length > 0)) return glm::vec3(0.0f);
    const glm::vec3 up = (*normals)[i] * (glm::dot((*normals)[i], normal) < 0 ? -1 / length : 1 / length);
    for (std::size_t other = 0; other < 3; ++other)
      if (other != i && !(glm::dot(corners[other] - corners[i], up) < 0)) return glm::vec3(0.0f);
    way -= weight[i] * glm::dot(point - corners[i], up) * up;
  }
  return way;
}

}  // namespace tress::geometry
