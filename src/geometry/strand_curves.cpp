#include "geometry/strand_curves.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "tress/base/random.h"

namespace tress::geometry {
namespace {

using scene::StrandBasis;

bool is_finite(const glm::vec3& x) { return std::isfinite(x.x) && std::isfinite(x.y) && std::isfinite(x.z); }

/// The points of a strand and the major semi-axes there; empty where it is not drawn. Repetitions are left out where
/// the basis lets them.
struct StrandPoints {
  std::vector<glm::vec3> position;
  std::vector<float> axis;
};

StrandPoints points_of(const scene::Groom& groom, std::uint32_t strand, float eccentricity) {
  const double axis_per_radius = fiber::major_semi_axis(1.0, eccentricity);
  const bool repeats_stay = groom.basis == StrandBasis::open_bspline || groom.basis == StrandBasis::bezier;
  StrandPoints points;
  for (std::uint32_t i = groom.first_point[strand]; i < groom.first_point[strand + 1]; ++i) {
    if (!is_finite(groom.points[i]) || !std::isfinite(groom.radius_cm[i])) return {};
    if (!repeats_stay && !points.position.empty() && points.position.back() == groom.points[i]) continue;
    points.position.push_back(groom.points[i]);
    points.axis.push_back(std::max(0.0f, static_cast<float>(axis_per_radius * groom.radius_cm[i])));
  }
  return points;
}

void add_strand(const scene::Groom& groom, std::uint32_t strand, float eccentricity, double root_angle_rad,
                double turn_rad_per_cm, StrandCurves& curves) {
  const StrandPoints points = points_of(groom, strand, eccentricity);
  const std::vector<glm::vec3>& p = points.position;
  const std::vector<float>& axes = points.axis;
  const std::vector<KnotFrame> frames =
      strand_frames(p, root_angle_rad, turn_rad_per_cm, groom.basis, groom.turned_rad);
  if (frames.empty()) return;
  const std::size_t count = p.size();
  // Reflected ends make the spline pass through root and tip. A reflected radius stops at 0.
  const auto reflect = [&](std::size_t end, std::size_t next) {
    return glm::vec4(2.0f * p[end] - p[next], std::max(0.0f, 2 * axes[end] - axes[next]));
  };
  const auto base = static_cast<std::uint32_t>(curves.control.size());
  if (groom.basis == StrandBasis::bspline) curves.control.push_back(reflect(0, 1));
  for (std::size_t i = 0; i < count; ++i) curves.control.emplace_back(p[i], axes[i]);
  if (groom.basis == StrandBasis::bspline) curves.control.push_back(reflect(count - 1, count - 2));
  const std::uint32_t stride = groom.basis == StrandBasis::bezier ? 3 : 1, controls = curves.is_linear() ? 2 : 4;
  for (std::uint32_t i = 0; i + 1 < frames.size(); ++i) {
    const std::uint32_t first = base + stride * i;
    curves.first_control.push_back(first);
    StrandSegment segment{frames[i], frames[i + 1], {}, strand, eccentricity};
    for (std::uint32_t c = 0; c < controls; ++c) segment.semi_axis[c] = curves.control[first + c].w;
    curves.segments.push_back(segment);
  }
}

}  // namespace

FiberFrame StrandCurves::frame(std::uint32_t segment, float t, const glm::vec3& tangent) const {
  return frame_between(segments[segment].from, segments[segment].to, t, tangent);
}

float StrandCurves::semi_axis(std::uint32_t segment, float t) const {
  const std::array<float, 4>& a = segments[segment].semi_axis;
  const float s = 1 - t;
  if (is_linear()) return s * a[0] + t * a[1];
  if (basis == StrandBasis::bezier) return s * s * s * a[0] + 3 * s * t * (s * a[1] + t * a[2]) + t * t * t * a[3];
  return (s * s * s * a[0] + (4 - 3 * t * t * (2 - t)) * a[1] + (4 - 3 * s * s * (2 - s)) * a[2] + t * t * t * a[3]) /
         6;
}

glm::vec3 StrandCurves::axis(std::uint32_t segment, float t) const {
  const glm::vec4* p = &control[first_control[segment]];
  return (1 - t) * glm::vec3(p[0]) + t * glm::vec3(p[1]);
}

bool StrandCurves::is_in_joint(std::uint32_t segment, float t, const glm::vec3& position,
                               const glm::vec3& direction) const {
  // The strand's next point beyond the joint. What the ray passes nearest to must not lie towards it.
  const bool at_root = t < 0.5f;
  if (at_root ? segment == 0 : segment + 1 == segments.size()) return false;
  const std::uint32_t neighbour = at_root ? segment - 1 : segment + 1;
  if (segments[neighbour].strand != segments[segment].strand) return false;
  const glm::vec4& joint = control[first_control[at_root ? segment : neighbour]];
  const glm::vec3 beyond = glm::vec3(control[first_control[neighbour] + (at_root ? 0 : 1)]) - glm::vec3(joint);
  const float towards = glm::dot(position - glm::vec3(joint), beyond);
  if (towards <= 0) return true;
  // A thousandth of the semi-axis on the neighbour as the ray sees it: rounding must not open the seam.
  const float along = glm::dot(beyond, direction), limit = 1e-3f * joint.w;
  return towards * towards <= limit * limit * (glm::dot(beyond, beyond) - along * along);
}

std::size_t StrandCurves::bytes() const {
  return control.capacity() * sizeof(glm::vec4) + first_control.capacity() * sizeof(std::uint32_t) +
         segments.capacity() * sizeof(StrandSegment);
}

StrandCurves strand_curves(const scene::Scene& scene, std::uint32_t groom_index) {
  const scene::Groom& groom = scene.grooms[groom_index];
  const scene::Material& material = scene.materials[groom.material];
  StrandCurves curves;
  curves.groom = groom_index;
  curves.basis = groom.basis;
  const std::uint32_t strands = groom.strand_count();
  curves.control.reserve(groom.points.size() + (groom.basis == StrandBasis::bspline ? 2 * std::size_t{strands} : 0));
  const std::size_t most_segments = groom.points.size() - std::min<std::size_t>(groom.points.size(), strands);
  curves.first_control.reserve(most_segments);
  curves.segments.reserve(most_segments);
  for (std::uint32_t strand = 0; strand < strands; ++strand) {
    const double hashed = 2 * std::numbers::pi * RandomStream(groom_index, strand).next();
    const double root_angle = material.root_angle_rad ? *material.root_angle_rad : hashed;
    const float eccentricity = scene.fibers[groom.fiber[strand]].eccentricity;
    const double curl_diameter =
        material.curl_diameter_cm ? *material.curl_diameter_cm : fiber::curl_diameter_cm(eccentricity);
    const double turn_rad_per_cm = material.twist && curl_diameter > 0 ? 2 / curl_diameter : 0;
    curves.elliptical = curves.elliptical || eccentricity < 1;
    add_strand(groom, strand, eccentricity, root_angle, turn_rad_per_cm, curves);
  }
  return curves;
}

}  // namespace tress::geometry
