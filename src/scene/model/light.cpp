#include "scene/model/light.h"

#include <algorithm>
#include <cmath>
#include <glm/ext/vector_double3.hpp>
#include <glm/geometric.hpp>

#include "base/pi.h"

namespace tress::scene {
namespace {

constexpr double smallest_spherical_rectangle = 1e-6;  ///< sr; below it, rounding of its angles would show

/// Directions within an angle of an axis, by 1 - cos of that angle: exact for the smallest cones.
struct Cone {
  double one_minus_cos;
  double solid_angle() const { return 2 * pi * one_minus_cos; }
  /// Draws a unit direction around `axis` (unit), uniform in solid angle. *below gets 1 - cos to the axis.
  glm::dvec3 draw(const glm::dvec3& axis, double u1, double u2, double* below) const {
    *below = u1 * one_minus_cos;
    const double sin_axis = std::sqrt(std::max(0.0, *below * (2 - *below)));
    const glm::dvec3 aside = std::abs(axis.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
    const glm::dvec3 x = glm::normalize(glm::cross(aside, axis)), y = glm::cross(axis, x);
    const double turn = 2 * pi * u2;
    return (1 - *below) * axis + sin_axis * (std::cos(turn) * x + std::sin(turn) * y);
  }
};

Cone distant_cone(const LightShape& light) {
  const double s = std::sin(0.5 * light.half_angle_rad);
  return {2 * s * s};
}

/// The cone of a sphere of radius r, seen from outside at distance d > r.
Cone sphere_cone(double r, double d) {
  const double sin2 = r / d * (r / d);
  return {sin2 / (1 + std::sqrt(std::max(0.0, 1 - sin2)))};
}

/// The result in single precision, or none if one of its values is not finite or nothing is visible.
LightSample finite_sample(const LightShape& light, const glm::dvec3& direction, double distance, double pdf) {
  LightSample sample;
  for (int c = 0; c < 3; ++c)
    if (!(std::abs(direction[c]) <= 1.5) || !std::isfinite(light.radiance[c])) return {};
  const float density = static_cast<float>(pdf);
  if (!(density > 0 && std::isfinite(density) && distance >= 0)) return {};
  sample.direction = glm::vec3(direction);
  sample.distance = static_cast<float>(std::min(distance, static_cast<double>(distant_cm)));
  sample.radiance = light.radiance;
  if (light.kind == LightShape::Kind::spot) sample.radiance *= static_cast<float>(spot_share(light, -sample.direction));
  sample.pdf_solid_angle = density;
  return sample;
}

/// A rectangle seen from a point: the point is the origin, x and y are along the edges, and the rectangle is at height
/// -depth.
struct SeenRectangle {
  glm::dvec3 x, y, n;
  double x0, x1, y0, y1, depth;  ///< depth > 0 if the point is on the side to which it shines
  double area = 0, solid_angle = 0;

  SeenRectangle(const LightShape& light, const glm::dvec3& point) {
    const glm::dvec3 u(light.edge_u), v(light.edge_v), to(glm::dvec3(light.center) - point);
    const double half_u = glm::length(u), half_v = glm::length(v);
    x = u / half_u;
    y = v / half_v;
    n = glm::cross(x, y);
    x0 = glm::dot(to, x) - half_u, x1 = x0 + 2 * half_u;
    y0 = glm::dot(to, y) - half_v, y1 = y0 + 2 * half_v;
    depth = -glm::dot(to, n);
    area = 4 * half_u * half_v;
    if (depth > 0) solid_angle = corner(x1, y1) - corner(x1, y0) - corner(x0, y1) + corner(x0, y0);
  }

  /// Signed solid angle of the rectangle from below the point to (a, b).
  double corner(double a, double b) const {
    return std::atan2(a * b, depth * std::sqrt(a * a + b * b + depth * depth));
  }

  bool by_area() const { return !(solid_angle > smallest_spherical_rectangle); }

  /// The density of the direction to the place (a, b).
  double pdf(double a, double b) const {
    if (!by_area()) return 1 / solid_angle;
    const double d2 = a * a + b * b + depth * depth;
    return d2 * std::sqrt(d2) / (depth * area);
  }

  /// Draws by Urena et al. 2013, equations 3 to 7, with the angles of the spherical rectangle as sums of corner().
  void draw(double u1, double u2, double* a, double* b) const {
    if (by_area()) {
      *a = x0 + u1 * (x1 - x0);
      *b = y0 + u2 * (y1 - y0);
      return;
    }
    const double depth2 = depth * depth;
    const double b0 = -y0 / std::sqrt(depth2 + y0 * y0), b1 = y1 / std::sqrt(depth2 + y1 * y1);
    const double angle = u1 * solid_angle + corner(x0, y1) - corner(x0, y0);
    const double f = (std::cos(angle) * b0 + b1) / std::sin(angle);
    const double across = std::sqrt(std::max(f * f - depth2 / (depth2 + y0 * y0), 1e-300));
    *a = std::clamp(std::copysign(depth / across, f), x0, x1);
    const double d = std::sqrt(*a * *a + depth2);
    const double h0 = y0 / std::sqrt(d * d + y0 * y0), h1 = y1 / std::sqrt(d * d + y1 * y1);
    const double h = h0 + u2 * (h1 - h0);
    *b = std::clamp(h * d / std::sqrt(std::max(1 - h * h, 1e-300)), y0, y1);
  }
};

LightSample sample_sphere(const LightShape& light, const glm::dvec3& point, double u1, double u2) {
  const glm::dvec3 to = glm::dvec3(light.center) - point;
  const double d = glm::length(to), r = light.radius_cm;
  if (!(d > r)) {
    const double z = 1 - 2 * u1, flat = std::sqrt(std::max(0.0, 1 - z * z));
    const glm::dvec3 direction(flat * std::cos(2 * pi * u2), flat * std::sin(2 * pi * u2), z);
    const double along = glm::dot(to, direction);
    return finite_sample(light, direction, along + std::sqrt(std::max(0.0, along * along + r * r - d * d)),
                         1 / (4 * pi));
  }
  const Cone cone = sphere_cone(r, d);
  double below;
  const glm::dvec3 direction = cone.draw(to / d, u1, u2, &below);
  const double half_chord = std::sqrt(std::max(0.0, r * r - d * d * below * (2 - below)));
  return finite_sample(light, direction, std::max(0.0, d * (1 - below) - half_chord), 1 / cone.solid_angle());
}

LightSample sample_rectangle(const LightShape& light, const glm::dvec3& point, double u1, double u2) {
  const SeenRectangle seen(light, point);
  if (!(seen.depth > 0)) return {};
  double a, b;
  seen.draw(u1, u2, &a, &b);
  const glm::dvec3 to = a * seen.x + b * seen.y - seen.depth * seen.n;
  const double distance = glm::length(to);
  return finite_sample(light, to / distance, distance, seen.pdf(a, b));
}

LightSample sphere_along(const LightShape& light, const glm::dvec3& origin, const glm::dvec3& direction) {
  const glm::dvec3 to = glm::dvec3(light.center) - origin;
  const double along = glm::dot(to, direction), r = light.radius_cm, d = glm::length(to);
  const glm::dvec3 aside = to - along * direction;
  const double half_chord2 = r * r - glm::dot(aside, aside);
  if (!(d > r)) return finite_sample(light, direction, along + std::sqrt(std::max(0.0, half_chord2)), 1 / (4 * pi));
  if (!(half_chord2 > 0 && along > 0)) return {};
  return finite_sample(light, direction, std::max(0.0, along - std::sqrt(half_chord2)),
                       1 / sphere_cone(r, d).solid_angle());
}

LightSample rectangle_along(const LightShape& light, const glm::dvec3& origin, const glm::dvec3& direction) {
  const SeenRectangle seen(light, origin);
  const double sinking = -glm::dot(direction, seen.n);
  if (!(seen.depth > 0 && sinking > 0)) return {};
  const double distance = seen.depth / sinking;
  const double a = distance * glm::dot(direction, seen.x), b = distance * glm::dot(direction, seen.y);
  if (!(a >= seen.x0 && a <= seen.x1 && b >= seen.y0 && b <= seen.y1)) return {};
  return finite_sample(light, direction, distance, seen.pdf(a, b));
}

}  // namespace

LightSample sample_light(const LightShape& light, const glm::vec3& point, float u1, float u2) {
  const glm::dvec3 from(point);
  switch (light.kind) {
    case LightShape::Kind::sphere:
    case LightShape::Kind::spot:
      return sample_sphere(light, from, u1, u2);
    case LightShape::Kind::rectangle:
      return sample_rectangle(light, from, u1, u2);
    case LightShape::Kind::distant:
      break;
  }
  const Cone cone = distant_cone(light);
  double below;
  const glm::dvec3 direction = cone.draw(glm::normalize(glm::dvec3(light.direction)), u1, u2, &below);
  return finite_sample(light, direction, distant_cm, 1 / cone.solid_angle());
}

LightSample light_along(const LightShape& light, const glm::vec3& origin, const glm::vec3& direction,
                        float max_distance) {
  const glm::dvec3 unit = glm::normalize(glm::dvec3(direction)), from(origin);
  LightSample met;
  if (light.is_ball()) {
    met = sphere_along(light, from, unit);
  } else if (light.kind == LightShape::Kind::rectangle) {
    met = rectangle_along(light, from, unit);
  } else {
    // 2 (1 - cos) is the squared distance of the unit directions, which does not cancel in the narrowest cone.
    const glm::dvec3 aside = unit - glm::normalize(glm::dvec3(light.direction));
    const Cone cone = distant_cone(light);
    if (glm::dot(aside, aside) <= 2 * cone.one_minus_cos)
      met = finite_sample(light, unit, distant_cm, 1 / cone.solid_angle());
  }
  return met.distance <= max_distance ? met : LightSample{};
}

namespace {

/// The vector with length 1, or `otherwise` if it has no direction.
glm::vec3 unit_or(const glm::vec3& way, const glm::vec3& otherwise) {
  const float length = glm::length(way);
  return length > 1e-6f ? way / length : otherwise;
}

/// Turns the direction about the vertical, counter-clockwise from above.
glm::vec3 turned(const glm::vec3& direction, float angle_rad) {
  const float c = std::cos(angle_rad), s = std::sin(angle_rad);
  return {c * direction.x - s * direction.y, s * direction.x + c * direction.y, direction.z};
}

float environment_turn_rad(const Scene& scene, float time) {
  const std::vector<float>& turns = scene.environment_turns_rad;
  const BetweenMoments at(time, turns.size());
  return turns[at.before] + at.share * (turns[at.before + 1] - turns[at.before]);
}

}  // namespace

LightShape light_during(const Light& light, float time) {
  if (light.later.empty()) return light;
  const BetweenMoments at(time, light.later.size() + 1);
  const LightShape& a = at.before == 0 ? light : light.later[at.before - 1];
  const LightShape& b = light.later[at.before];
  const auto between = [&](const auto& from, const auto& to) { return from + at.share * (to - from); };
  LightShape now = a;
  now.radiance = between(a.radiance, b.radiance);
  now.center = between(a.center, b.center);
  now.radius_cm = between(a.radius_cm, b.radius_cm);
  if (a.direction != b.direction) now.direction = unit_or(between(a.direction, b.direction), a.direction);
  if (a.edge_u == b.edge_u && a.edge_v == b.edge_v) return now;
  const float u_length = glm::length(a.edge_u), v_length = glm::length(a.edge_v);
  const glm::vec3 u = unit_or(between(a.edge_u, b.edge_u), a.edge_u / u_length);
  const glm::vec3 v = between(a.edge_v, b.edge_v), square = v - glm::dot(v, u) * u, before = a.edge_v / v_length;
  const glm::vec3 across = glm::length(square) > 1e-3f * v_length ? square : before - glm::dot(before, u) * u;
  now.edge_u = u * between(u_length, glm::length(b.edge_u));
  now.edge_v = unit_or(across, before) * between(v_length, glm::length(b.edge_v));
  return now;
}

glm::vec3 turned_with_environment(const Scene& scene, const glm::vec3& direction, float time) {
  if (scene.environment_turns_rad.empty()) return direction;
  return turned(direction, environment_turn_rad(scene, time));
}

glm::vec3 turned_to_environment(const Scene& scene, const glm::vec3& direction, float time) {
  if (scene.environment_turns_rad.empty()) return direction;
  return turned(direction, -environment_turn_rad(scene, time));
}

glm::vec3 direction_towards(double azimuth_rad, double elevation_rad) {
  const double flat = std::cos(elevation_rad);
  return glm::vec3(flat * std::sin(azimuth_rad), -flat * std::cos(azimuth_rad), std::sin(elevation_rad));
}

double spot_share(const LightShape& light, const glm::vec3& direction) {
  // 2 (1 - cos) is the squared distance of the unit directions, which does not cancel in the narrowest cone.
  const glm::dvec3 aside = glm::dvec3(direction) - glm::dvec3(light.direction);
  const double off_axis = 0.5 * glm::dot(aside, aside), core = light.core, cone = light.cone;
  if (off_axis <= core) return 1;
  if (!(off_axis < cone)) return 0;
  const double t = (cone - off_axis) / (cone - core);
  return t * t * (3 - 2 * t);
}

glm::vec3 spot_radiance(const glm::vec3& irradiance, double radius_cm, double distance_cm) {
  const double ratio = std::max(1.0, distance_cm / radius_cm);
  return irradiance * static_cast<float>(ratio * ratio / pi);
}

std::vector<std::string> light_groups(const Scene& scene) {
  std::vector<std::string> names;
  bool others = false;
  const auto add = [&](const std::string& name) {
    if (name.empty()) others = true;
    if (!name.empty() && std::ranges::find(names, name) == names.end()) names.push_back(name);
  };
  if (scene.environment.mean() != glm::vec3(0.0f)) add(scene.environment_group);
  for (const Light& light : scene.lights) add(light.group);
  if (!names.empty() && others && std::ranges::find(names, other_lights) == names.end())
    names.emplace_back(other_lights);
  return names;
}

std::size_t group_index(const std::vector<std::string>& groups, const std::string& name) {
  const auto found = std::ranges::find(groups, name.empty() ? other_lights : name);
  return found == groups.end() ? 0 : static_cast<std::size_t>(found - groups.begin());
}

bool is_group_name(const std::string& name) {
  const auto is_plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  };
  return !name.empty() && name.size() <= 64 && std::ranges::all_of(name, is_plain);
}

glm::vec3 distant_radiance(const glm::vec3& irradiance, double half_angle_rad) {
  const double s = std::sin(half_angle_rad);
  return irradiance * static_cast<float>(1 / (pi * s * s));
}

}  // namespace tress::scene
