#include "integrate/light_clearance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "geometry/surface_hits.h"
#include "scene/model/groom_bounds.h"

namespace tress::integrate {
namespace {

constexpr double half_unit = 0x1p-24;
constexpr double largest_sliver = 3e3;  ///< bound of 3 longest^2 / (2 area): almost no ray meets a thinner triangle

double largest_of(const glm::dvec3& p) { return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}); }

/// The extent of a light: its middle, and how far it reaches from there along any axis. For a moving light it is the
/// ball that contains it from one moment of the shutter to the next.
struct Extent {
  glm::dvec3 center, u, v;
  double radius;
  double size;           ///< radius of the light, or the sum of its half edges
  bool is_flat = false;  ///< true for a rectangle that does not move

  explicit Extent(const scene::LightShape& light)
      : center(light.center), u(0.0), v(0.0), radius(light.radius_cm), size(radius) {
    if (light.is_ball()) return;
    u = light.edge_u, v = light.edge_v;
    radius = 0;
    is_flat = true;
    size = glm::length(u) + glm::length(v);
  }
  Extent(const scene::LightShape& a, const scene::LightShape& b)
      : center(0.5 * (glm::dvec3(a.center) + glm::dvec3(b.center))),
        u(0.0),
        v(0.0),
        size(std::max(Extent(a).size, Extent(b).size)) {
    radius = size + 0.5 * glm::distance(glm::dvec3(a.center), glm::dvec3(b.center));
  }
  double reach(const glm::dvec3& axis) const {
    return radius + std::abs(glm::dot(axis, u)) + std::abs(glm::dot(axis, v));
  }
  double largest_coordinate() const {
    double largest = 0;
    for (const glm::dvec3& axis : {glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1)}) {
      largest = std::max(largest, std::abs(glm::dot(axis, center)) + reach(axis));
    }
    return largest;
  }
  /// Whether all points are further away than `within` along a unit axis.
  bool is_clear_of(const std::array<glm::dvec3, 3>& points, const glm::dvec3& axis, double within) const {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const glm::dvec3& point : points) {
      const double along = glm::dot(axis, point - center);
      low = std::min(low, along);
      high = std::max(high, along);
    }
    return low > reach(axis) + within || -high > reach(axis) + within;
  }
};

/// The part of the bound that comes from a triangle.
double triangle_bound(const std::array<glm::dvec3, 3>& p) {
  const double size = glm::length(glm::cross(p[1] - p[0], p[2] - p[0]));
  const double longest = std::max({glm::length(p[1] - p[0]), glm::length(p[2] - p[0]), glm::length(p[2] - p[1])});
  const double sliver = size > 0 ? longest * std::min(3 * longest * longest / size, largest_sliver) : 0;
  return half_unit * (8.7 * std::max({largest_of(p[0]), largest_of(p[1]), largest_of(p[2])}) + sliver);
}

/// The part of the bound that does not depend on the ray; 0 if no mesh is near. normal: that of a rectangle.
double fixed_bound(const Extent& extent, const glm::dvec3& normal, const scene::Scene& scene,
                   const SceneSize& of_scene) {
  const double world = std::max(of_scene.coordinate_cm, extent.largest_coordinate());
  const double of_light = half_unit * (1.8 * extent.largest_coordinate() + 8 * extent.size + 62 * of_scene.radius_cm);
  // The bound for a ray across the whole scene, without the part of the triangle.
  const double near = of_light + half_unit * (8.7 + 6 * 2 * std::sqrt(3.0)) * world;
  const glm::dvec3 x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  double fixed_cm = 0;
  const auto keep_clear = [&](const scene::Mesh& mesh, const std::vector<glm::vec3>& positions) {
    for (const glm::uvec3& corner : mesh.triangles) {
      const std::array<glm::dvec3, 3> points{positions[corner.x], positions[corner.y], positions[corner.z]};
      const double own = triangle_bound(points), within = near + own;
      const glm::dvec3 across = glm::cross(points[1] - points[0], points[2] - points[0]);
      const double area = glm::length(across);
      if (!(area > 0)) continue;  // no ray meets it
      const auto is_clear = [&](const glm::dvec3& axis) { return extent.is_clear_of(points, axis, within); };
      if (is_clear(x) || is_clear(y) || is_clear(z) || is_clear(across / area)) continue;
      if (extent.is_flat && is_clear(normal)) continue;
      fixed_cm = std::max(fixed_cm, of_light + own);
    }
  };
  for (const scene::Mesh& mesh : scene.meshes) {
    keep_clear(mesh, mesh.positions);
    for (const scene::MeshMoment& moment : mesh.later) keep_clear(mesh, moment.positions);
  }
  return fixed_cm;
}

}  // namespace

SceneSize::SceneSize(const scene::Scene& scene) {
  for (const scene::Groom& groom : scene.grooms) {
    double largest_cm = 0;
    const auto include = [&](const std::vector<float>& radii) {
      for (const float each : radii) largest_cm = std::max(largest_cm, static_cast<double>(each));
    };
    include(groom.radius_cm);
    for (const scene::StrandMoment& moment : groom.later) include(moment.radius_cm);
    radius_cm = std::max(radius_cm, scene::largest_scale(groom) * largest_cm);
    scene::for_each_bounding_point(
        groom, [&](const glm::vec3& point) { coordinate_cm = std::max(coordinate_cm, largest_of(point)); });
  }
  for (const scene::Mesh& mesh : scene.meshes) {
    coordinate_cm = std::max(coordinate_cm, static_cast<double>(geometry::largest_coordinate(mesh)));
  }
}

LightClearance::LightClearance(const scene::Light& light, const scene::Scene& scene, const SceneSize& of_scene) {
  if (light.kind == scene::Light::Kind::distant) return;
  place(light);
  std::vector<Extent> extents;
  if (light.later.empty()) extents.emplace_back(light);
  for (std::size_t i = 0; i < light.later.size(); ++i)
    extents.emplace_back(i == 0 ? light : light.later[i - 1], light.later[i]);
  for (const Extent& extent : extents) fixed_cm_ = std::max(fixed_cm_, fixed_bound(extent, normal_, scene, of_scene));
}

void LightClearance::place(const scene::LightShape& shape) {
  is_sphere_ = shape.is_ball();
  center_ = shape.center;
  radius_cm_ = shape.radius_cm;
  normal_ = glm::normalize(glm::cross(glm::dvec3(shape.edge_u), glm::dvec3(shape.edge_v)));
}

LightClearance LightClearance::at(const scene::LightShape& shape) const {
  LightClearance moved = *this;
  if (shape.kind != scene::LightShape::Kind::distant) moved.place(shape);
  return moved;
}

double LightClearance::bound_cm(const glm::vec3& origin, double distance_cm) const {
  return fixed_cm_ > 0 ? fixed_cm_ + half_unit * (8.7 * largest_of(origin) + 6 * distance_cm) : 0;
}

double LightClearance::height(const glm::dvec3& point, const glm::dvec3& origin, glm::dvec3* normal) const {
  if (!is_sphere_) {
    *normal = normal_;
    return glm::dot(point - center_, normal_);
  }
  const glm::dvec3 out = point - center_;
  const double distance = glm::length(out), side = glm::length(origin - center_) > radius_cm_ ? 1 : -1;
  *normal = distance > 0 ? side * out / distance : glm::dvec3(0, 0, 1);
  return side * (distance - radius_cm_);
}

LightClearance::Segment LightClearance::shadow(const glm::vec3& origin, const glm::vec3& direction,
                                               float distance_cm) const {
  const double bound = bound_cm(origin, static_cast<double>(distance_cm));
  if (!(bound > 0)) return {direction, distance_cm};
  const glm::dvec3 from(origin), end = from + static_cast<double>(distance_cm) * glm::dvec3(direction);
  glm::dvec3 normal;
  const double lift = bound - height(end, from, &normal);
  const glm::dvec3 way = end + lift * normal - from;
  const double length = glm::length(way);
  if (!(length > 0)) return {direction, 0};
  return {glm::vec3(way / length), static_cast<float>(length)};
}

bool LightClearance::is_seen(const glm::vec3& origin, const glm::vec3& direction, float light_cm, float hit_cm) const {
  if (light_cm <= hit_cm) return true;
  const double bound = bound_cm(origin, static_cast<double>(light_cm));
  if (!(bound > 0)) return false;
  glm::dvec3 normal;
  const glm::dvec3 from(origin), met = from + static_cast<double>(hit_cm) * glm::dvec3(direction);
  return height(met, from, &normal) <= bound;
}

}  // namespace tress::integrate
