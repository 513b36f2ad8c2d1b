#include "intersect/fiber_scene.h"

#include <atomic>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <vector>

#include "intersect/embree_compat.h"
#include "intersect/strand_curves.h"

namespace tress::intersect {
namespace {

/// Refuses a hit on the circumscribed ribbon that lies outside the ellipse's silhouette: |v| > w(phi), phi the
/// azimuth of the ray about the local frame. A ray along the tangent has no azimuth and is kept.
void silhouette_filter(const RTCFilterFunctionNArguments* arguments) {
  const auto& curves = *static_cast<const StrandCurves*>(arguments->geometryUserPtr);
  for (unsigned int i = 0; i < arguments->N; ++i) {
    if (arguments->valid[i] == 0) continue;
    const float lateral = RTCHitN_v(arguments->hit, arguments->N, i);
    const float eccentricity = curves.eccentricity[RTCHitN_primID(arguments->hit, arguments->N, i)];
    if (std::abs(lateral) <= eccentricity) continue;  // w >= e: inside from every side
    const glm::vec3 tangent = glm::normalize(glm::vec3(RTCHitN_Ng_x(arguments->hit, arguments->N, i),
                                                       RTCHitN_Ng_y(arguments->hit, arguments->N, i),
                                                       RTCHitN_Ng_z(arguments->hit, arguments->N, i)));
    const glm::vec3 direction(RTCRayN_dir_x(arguments->ray, arguments->N, i),
                              RTCRayN_dir_y(arguments->ray, arguments->N, i),
                              RTCRayN_dir_z(arguments->ray, arguments->N, i));
    const FiberFrame frame = curves.frame(RTCHitN_primID(arguments->hit, arguments->N, i),
                                          RTCHitN_u(arguments->hit, arguments->N, i), tangent);
    // w^2 = (e^2 d_v^2 + d_w^2) / (d_v^2 + d_w^2)
    const float major = glm::dot(direction, frame.v) * glm::dot(direction, frame.v);
    const float minor = glm::dot(direction, frame.w) * glm::dot(direction, frame.w);
    const float silhouette = eccentricity * eccentricity * major + minor;
    if (lateral * lateral * (major + minor) > silhouette) arguments->valid[i] = 0;
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
  std::vector<StrandCurves> grooms;  ///< read by Embree and the filter: must not move
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
    self.grooms.push_back(strand_curves(scene, index));
    StrandCurves& curves = self.grooms.back();
    if (curves.first_control.empty()) continue;
    RTCGeometry geometry = rtcNewGeometry(self.device, RTC_GEOMETRY_TYPE_FLAT_BSPLINE_CURVE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, curves.control.data(), 0,
                               sizeof(glm::vec4), curves.control.size());
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, curves.first_control.data(), 0,
                               sizeof(std::uint32_t), curves.first_control.size());
    rtcSetGeometryMask(geometry, 0xFFFFFFFF);
    rtcSetGeometryUserData(geometry, &curves);
    if (curves.elliptical) {
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
  const StrandCurves& curves = implementation_->grooms[query.hit.geomID];
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
  for (const StrandCurves& curves : implementation_->grooms) total += curves.bytes();
  return total;
}

}  // namespace tress::intersect
