#include "intersect/fiber_scene.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <numbers>
#include <vector>

#include "intersect/embree_compat.h"
#include "intersect/strand_frames.h"
#include "tress/adaptive/random.h"

namespace tress::intersect {
namespace {

/// One groom as Embree sees it. Every strand of n points has n + 2 control points and n - 1 segments; segment with
/// first control point c runs from knot c + 1 to knot c + 2. `frames` has the same indices as `control`.
struct Curves {
  std::vector<glm::vec4> control;  ///< xyz, cm; w = major semi-axis, cm
  std::vector<KnotFrame> frames;
  std::vector<std::uint32_t> first_control;  ///< per segment
  std::vector<std::uint32_t> strand;         ///< per segment
  float eccentricity = 1;

  FiberFrame frame(std::uint32_t segment, float t, const glm::vec3& tangent) const {
    const std::uint32_t c = first_control[segment];
    return frame_between(frames[c + 1], frames[c + 2], t, tangent);
  }

  /// Major semi-axis on a segment, cm: the uniform cubic B-spline of the control values.
  float semi_axis(std::uint32_t segment, float t) const {
    const glm::vec4* p = &control[first_control[segment]];
    const float s = 1 - t;
    return (s * s * s * p[0].w + (4 - 3 * t * t * (2 - t)) * p[1].w + (4 - 3 * s * s * (2 - s)) * p[2].w +
            t * t * t * p[3].w) /
           6;
  }

  std::size_t bytes() const {
    return control.capacity() * sizeof(glm::vec4) + frames.capacity() * sizeof(KnotFrame) +
           (first_control.capacity() + strand.capacity()) * sizeof(std::uint32_t);
  }
};

bool is_finite(const glm::vec3& x) { return std::isfinite(x.x) && std::isfinite(x.y) && std::isfinite(x.z); }

/// Points of a strand without repetitions; strands with less than two points left are not drawn.
void add_strand(const scene::Groom& groom, std::uint32_t strand, double axis_per_radius, double root_angle_rad,
                double turn_rad_per_cm, Curves& curves) {
  std::vector<glm::vec3> points;
  std::vector<float> axes;
  for (std::uint32_t i = groom.first_point[strand]; i < groom.first_point[strand + 1]; ++i) {
    if (!is_finite(groom.points[i]) || !std::isfinite(groom.radius_cm[i])) return;
    if (!points.empty() && points.back() == groom.points[i]) continue;
    points.push_back(groom.points[i]);
    axes.push_back(std::max(0.0f, static_cast<float>(axis_per_radius * groom.radius_cm[i])));
  }
  const std::size_t count = points.size();
  if (count < 2) return;
  const std::vector<KnotFrame> frames = strand_frames(points, root_angle_rad, turn_rad_per_cm);
  // Reflected ends make the spline pass through root and tip. A reflected radius stops at 0.
  const auto reflect = [](const glm::vec3& end, float end_axis, const glm::vec3& next, float next_axis) {
    return glm::vec4(2.0f * end - next, std::max(0.0f, 2 * end_axis - next_axis));
  };
  const auto base = static_cast<std::uint32_t>(curves.control.size());
  curves.control.push_back(reflect(points[0], axes[0], points[1], axes[1]));
  curves.frames.push_back(frames[0]);
  for (std::size_t i = 0; i < count; ++i) {
    curves.control.emplace_back(points[i], axes[i]);
    curves.frames.push_back(frames[i]);
  }
  curves.control.push_back(reflect(points[count - 1], axes[count - 1], points[count - 2], axes[count - 2]));
  curves.frames.push_back(frames[count - 1]);
  for (std::uint32_t i = 0; i + 1 < count; ++i) {
    curves.first_control.push_back(base + i);
    curves.strand.push_back(strand);
  }
}

Curves make_curves(const scene::Scene& scene, std::uint32_t groom_index) {
  const scene::Groom& groom = scene.grooms[groom_index];
  const scene::Material& material = scene.materials[groom.material];
  Curves curves;
  curves.eccentricity = material.fiber.eccentricity;
  const double axis_per_radius = fiber::major_semi_axis(1.0, curves.eccentricity);
  const double curl_diameter =
      material.curl_diameter_cm ? *material.curl_diameter_cm : fiber::curl_diameter_cm(curves.eccentricity);
  const double turn_rad_per_cm = material.twist && curl_diameter > 0 ? 2 / curl_diameter : 0;
  const std::uint32_t strands = groom.strand_count();
  curves.control.reserve(groom.points.size() + 2 * std::size_t{strands});
  curves.frames.reserve(curves.control.capacity());
  for (std::uint32_t strand = 0; strand < strands; ++strand) {
    const double hashed = 2 * std::numbers::pi * RandomStream(groom_index, strand).next();
    const double root_angle = material.root_angle_rad ? *material.root_angle_rad : hashed;
    add_strand(groom, strand, axis_per_radius, root_angle, turn_rad_per_cm, curves);
  }
  return curves;
}

/// Refuses a hit on the circumscribed ribbon that lies outside the ellipse's silhouette: |v| > w(phi), phi the
/// azimuth of the ray about the local frame. A ray along the tangent has no azimuth and is kept.
void silhouette_filter(const RTCFilterFunctionNArguments* arguments) {
  const auto& curves = *static_cast<const Curves*>(arguments->geometryUserPtr);
  for (unsigned int i = 0; i < arguments->N; ++i) {
    if (arguments->valid[i] == 0) continue;
    const glm::vec3 tangent = glm::normalize(glm::vec3(RTCHitN_Ng_x(arguments->hit, arguments->N, i),
                                                       RTCHitN_Ng_y(arguments->hit, arguments->N, i),
                                                       RTCHitN_Ng_z(arguments->hit, arguments->N, i)));
    const glm::vec3 direction(RTCRayN_dir_x(arguments->ray, arguments->N, i),
                              RTCRayN_dir_y(arguments->ray, arguments->N, i),
                              RTCRayN_dir_z(arguments->ray, arguments->N, i));
    const FiberFrame frame = curves.frame(RTCHitN_primID(arguments->hit, arguments->N, i),
                                          RTCHitN_u(arguments->hit, arguments->N, i), tangent);
    const float along_major = curves.eccentricity * glm::dot(direction, frame.v);
    const float along_minor = glm::dot(direction, frame.w);
    const float along_v = glm::dot(direction, frame.v);
    const float lateral = RTCHitN_v(arguments->hit, arguments->N, i);
    const float projected = along_v * along_v + along_minor * along_minor;
    if (lateral * lateral * projected > along_major * along_major + along_minor * along_minor) arguments->valid[i] = 0;
  }
}

bool count_bytes(void* user, ssize_t bytes, bool) {
  *static_cast<std::atomic<std::ptrdiff_t>*>(user) += bytes;
  return true;
}

RTCRay embree_ray(const Ray& ray) {
  RTCRay out{};
  out.org_x = ray.origin.x;
  out.org_y = ray.origin.y;
  out.org_z = ray.origin.z;
  out.dir_x = ray.direction.x;
  out.dir_y = ray.direction.y;
  out.dir_z = ray.direction.z;
  out.tfar = std::numeric_limits<float>::infinity();
  out.mask = 0xFFFFFFFF;
  return out;
}

}  // namespace

struct FiberScene::Implementation {
  std::atomic<std::ptrdiff_t> embree_bytes{0};
  std::vector<Curves> grooms;  ///< read by Embree and the filter: must not move
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
};

FiberScene::FiberScene(const scene::Scene& scene) : implementation_(std::make_unique<Implementation>()) {
  Implementation& self = *implementation_;
  self.device = rtcNewDevice("");
  rtcSetDeviceMemoryMonitorFunction(self.device, count_bytes, &self.embree_bytes);
  self.scene = rtcNewScene(self.device);
  self.grooms.reserve(scene.grooms.size());
  for (std::uint32_t index = 0; index < scene.grooms.size(); ++index) {
    self.grooms.push_back(make_curves(scene, index));
    Curves& curves = self.grooms.back();
    if (curves.first_control.empty()) continue;
    RTCGeometry geometry = rtcNewGeometry(self.device, RTC_GEOMETRY_TYPE_FLAT_BSPLINE_CURVE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, curves.control.data(), 0,
                               sizeof(glm::vec4), curves.control.size());
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, curves.first_control.data(), 0,
                               sizeof(std::uint32_t), curves.first_control.size());
    rtcSetGeometryMask(geometry, 0xFFFFFFFF);
    rtcSetGeometryUserData(geometry, &curves);
    if (curves.eccentricity < 1) {
      rtcSetGeometryIntersectFilterFunction(geometry, silhouette_filter);
      rtcSetGeometryOccludedFilterFunction(geometry, silhouette_filter);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(self.scene, geometry, index);
    rtcReleaseGeometry(geometry);
  }
  rtcJoinCommitScene(self.scene);
}

FiberScene::~FiberScene() {
  rtcReleaseScene(implementation_->scene);
  rtcReleaseDevice(implementation_->device);
}

std::optional<Hit> FiberScene::intersect(const Ray& ray) const {
  RTCRayHit query{};
  query.ray = embree_ray(ray);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  embree::intersect1(implementation_->scene, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  const Curves& curves = implementation_->grooms[query.hit.geomID];
  const glm::vec3 tangent = glm::normalize(glm::vec3(query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z));
  const FiberFrame frame = curves.frame(query.hit.primID, query.hit.u, tangent);
  Hit hit;
  hit.distance_cm = query.ray.tfar;
  hit.position = ray.origin + query.ray.tfar * ray.direction;
  const glm::vec3 side = glm::cross(ray.direction, frame.u);
  const float sine = glm::length(side);
  const float offset = query.hit.v * curves.semi_axis(query.hit.primID, query.hit.u);
  hit.axis = sine > 1e-6f ? hit.position - (offset / sine) * side : hit.position;
  hit.u = frame.u;
  hit.v = frame.v;
  hit.w = frame.w;
  hit.groom = query.hit.geomID;
  hit.strand = curves.strand[query.hit.primID];
  hit.lateral = query.hit.v;
  return hit;
}

bool FiberScene::occluded(const Ray& ray) const {
  RTCRay query = embree_ray(ray);
  embree::occluded1(implementation_->scene, &query);
  return query.tfar < 0;
}

std::size_t FiberScene::bytes() const {
  std::size_t total = static_cast<std::size_t>(implementation_->embree_bytes.load());
  for (const Curves& curves : implementation_->grooms) total += curves.bytes();
  return total;
}

}  // namespace tress::intersect
