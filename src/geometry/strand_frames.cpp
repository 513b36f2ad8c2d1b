#include "geometry/strand_frames.h"

#include <cmath>
#include <glm/geometric.hpp>

namespace tress::geometry {
namespace {

/// Reflects x in the plane orthogonal to `axis` (any length; zero: unchanged).
glm::dvec3 reflect_across(const glm::dvec3& x, const glm::dvec3& axis) {
  const double length_squared = glm::dot(axis, axis);
  return length_squared > 0 ? x - (2 * glm::dot(axis, x) / length_squared) * axis : x;
}

glm::dvec3 least_aligned_normal(const glm::dvec3& tangent) {
  const glm::dvec3 size = glm::abs(tangent);
  glm::dvec3 axis(0, 0, 1);
  if (size.x <= size.y && size.x <= size.z) {
    axis = {1, 0, 0};
  } else if (size.y <= size.z) {
    axis = {0, 1, 0};
  }
  return glm::normalize(axis - glm::dot(axis, tangent) * tangent);
}

struct Knots {
  std::vector<glm::dvec3> position, tangent;  ///< tangents are unit
};

/// Unit, or 0.
glm::dvec3 direction_of(const glm::dvec3& x) {
  const double length = glm::length(x);
  return length > 0 ? x / length : glm::dvec3(0);
}

/// Knots of the uniform cubic B-spline: (p- + 4 p + p+)/6, tangent along p+ - p-. Linear: p, tangent halfway between
/// the directions of the two segments.
Knots strand_knots(std::span<const glm::vec3> points, bool linear) {
  const std::size_t count = points.size();
  Knots knots;
  knots.position.resize(count);
  knots.tangent.assign(count, glm::dvec3(0));
  for (std::size_t i = 0; i < count; ++i) {
    const glm::dvec3 here = points[i];
    const glm::dvec3 before = i > 0 ? glm::dvec3(points[i - 1]) : 2.0 * here - glm::dvec3(points[i + 1]);
    const glm::dvec3 after = i + 1 < count ? glm::dvec3(points[i + 1]) : 2.0 * here - glm::dvec3(points[i - 1]);
    knots.position[i] = linear ? here : (before + 4.0 * here + after) / 6.0;
    knots.tangent[i] = direction_of(linear ? direction_of(after - here) + direction_of(here - before) : after - before);
  }
  // Where points coincide the tangent is that of the neighbour, towards the tip first.
  for (std::size_t i = count - 1; i-- > 0;) {
    if (knots.tangent[i] == glm::dvec3(0)) knots.tangent[i] = knots.tangent[i + 1];
  }
  if (knots.tangent[0] == glm::dvec3(0)) knots.tangent[0] = {0, 0, 1};
  for (std::size_t i = 1; i < count; ++i) {
    if (knots.tangent[i] == glm::dvec3(0)) knots.tangent[i] = knots.tangent[i - 1];
  }
  return knots;
}

}  // namespace

glm::vec3 root_normal(const glm::vec3& tangent) { return least_aligned_normal(tangent); }

std::vector<KnotFrame> strand_frames(std::span<const glm::vec3> points, double root_angle_rad, double turn_rad_per_cm,
                                     bool linear) {
  std::vector<KnotFrame> frames;
  if (points.size() < 2) return frames;
  frames.reserve(points.size());
  const Knots knots = strand_knots(points, linear);
  glm::dvec3 normal = least_aligned_normal(knots.tangent[0]);
  double length = 0;
  frames.push_back({normal, static_cast<float>(root_angle_rad)});
  for (std::size_t i = 1; i < points.size(); ++i) {
    const glm::dvec3 step = knots.position[i] - knots.position[i - 1];
    const glm::dvec3 tangent_reflected = reflect_across(knots.tangent[i - 1], step);
    normal = reflect_across(reflect_across(normal, step), knots.tangent[i] - tangent_reflected);
    normal -= glm::dot(normal, knots.tangent[i]) * knots.tangent[i];
    const double size = glm::length(normal);
    normal = size > 1e-9 ? normal / size : least_aligned_normal(knots.tangent[i]);
    length += glm::length(step);
    frames.push_back({normal, static_cast<float>(root_angle_rad + turn_rad_per_cm * length)});
  }
  return frames;
}

FiberFrame frame_between(const KnotFrame& a, const KnotFrame& b, float t, const glm::vec3& tangent) {
  glm::vec3 normal = (1 - t) * a.normal + t * b.normal;
  normal -= glm::dot(normal, tangent) * tangent;
  const float size = glm::length(normal);
  normal = size > 1e-3f ? normal / size : root_normal(tangent);
  const float angle = (1 - t) * a.angle + t * b.angle;
  const glm::vec3 binormal = glm::cross(tangent, normal);
  const glm::vec3 v = std::cos(angle) * normal + std::sin(angle) * binormal;
  return {tangent, v, glm::cross(tangent, v)};
}

}  // namespace tress::geometry
