// Straight elliptical strands and, for them, the exact answer to a ray: written apart from src/intersect.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <vector>

#include "geometry/fiber_scene.h"
#include "geometry/strand_frames.h"
#include "scene/model/strand_fibers.h"
#include "tress/base/random.h"

namespace tress::geometry {

inline glm::vec3 random_direction(RandomStream& random) {
  const float z = 2 * random.next() - 1, phi = 6.2831853f * random.next(), s = std::sqrt(1 - z * z);
  return {s * std::cos(phi), s * std::sin(phi), z};
}

inline glm::vec3 random_point(RandomStream& random, float half) {
  const float x = random.next(), y = random.next(), z = random.next();
  return half * (2.0f * glm::vec3(x, y, z) - 1.0f);
}

struct StraightStrand {
  glm::vec3 root, tip;
  float root_radius_cm, tip_radius_cm;
  float eccentricity;
};

inline constexpr double straight_root_angle = 0.3, straight_curl_cm = 0.9;

/// All in one groom, twisted: the major axis turns by 2/0.9 rad a centimetre.
inline scene::Scene straight_scene(const std::vector<StraightStrand>& strands, bool linear, int points_each = 5) {
  scene::Scene scene;
  scene.materials.resize(1);
  scene.materials[0].root_angle_rad = straight_root_angle;
  scene.materials[0].curl_diameter_cm = straight_curl_cm;
  scene::Groom groom;
  groom.basis = linear ? scene::StrandBasis::linear : scene::StrandBasis::bspline;
  groom.first_point = {0};
  for (const StraightStrand& strand : strands) {
    for (int i = 0; i < points_each; ++i) {
      const float t = static_cast<float>(i) / static_cast<float>(points_each - 1);
      groom.points.push_back((1 - t) * strand.root + t * strand.tip);
      groom.radius_cm.push_back((1 - t) * strand.root_radius_cm + t * strand.tip_radius_cm);
    }
    groom.first_point.push_back(static_cast<std::uint32_t>(groom.points.size()));
  }
  scene.grooms.push_back(groom);
  scene::assign_fibers(&scene);
  const fiber::FiberParameters parameters = scene.fibers[0];
  scene.fibers.clear();
  scene.grooms[0].choices.clear();
  scene.grooms[0].choices_a_station = 1;
  for (std::size_t i = 0; i < strands.size(); ++i) {
    scene.fibers.push_back(parameters);
    scene.fibers.back().eccentricity = strands[i].eccentricity;
    scene.grooms[0].choices.push_back({0, static_cast<std::uint16_t>(i)});
  }
  return scene;
}

struct ExactMeeting {
  double distance = 0;  ///< along the ray, of its nearest point to the axis
  double axis = 0;      ///< major semi-axis there, cm
  bool met = false;
  /// How near the decision is to the other one: of the lateral offset to the silhouette, of the ends, over the
  /// major semi-axis; along the ray likewise.
  double margin = 0;
};

/// The strand as a ribbon that faces the ray, as wide as the silhouette of the ellipse, between 0 and `far` along it.
inline ExactMeeting exact_meeting(const StraightStrand& strand, const Ray& ray,
                                  double far = std::numeric_limits<double>::infinity()) {
  const glm::dvec3 root = strand.root, chord = glm::dvec3(strand.tip) - root, o = ray.origin;
  const double length = glm::length(chord);
  const glm::dvec3 u = chord / length, d = glm::normalize(glm::dvec3(ray.direction));
  const double cosine = glm::dot(d, u), sine2 = std::max(1e-12, 1 - cosine * cosine);
  const glm::dvec3 from = o - root;
  ExactMeeting meeting;
  meeting.distance = (cosine * glm::dot(from, u) - glm::dot(from, d)) / sine2;
  const double s = glm::dot(from, u) + meeting.distance * cosine;
  const double offset = glm::length(from + meeting.distance * d - s * u);
  const double part = std::clamp(s / length, 0.0, 1.0);
  const double radius = (1 - part) * strand.root_radius_cm + part * strand.tip_radius_cm;
  meeting.axis = fiber::major_semi_axis(radius, strand.eccentricity);
  const glm::dvec3 normal = root_normal(u);
  const double angle = straight_root_angle + 2 * s / straight_curl_cm;
  const glm::dvec3 v = std::cos(angle) * normal + std::sin(angle) * glm::cross(u, normal);
  const double dv = glm::dot(d, v), dw = glm::dot(d, glm::cross(u, v)), e = strand.eccentricity;
  const double width = std::sqrt((dw * dw + e * e * dv * dv) / (dv * dv + dw * dw));
  const double inside = std::min({width - offset / meeting.axis, s / meeting.axis, (length - s) / meeting.axis,
                                  meeting.distance / meeting.axis, (far - meeting.distance) / meeting.axis});
  meeting.met = inside > 0;
  meeting.margin = std::abs(inside);
  return meeting;
}

}  // namespace tress::geometry
