// Shadow rays eight at a time, and all in one stream, against one by one: Embree alone, no filter, round strands.
#pragma once

#include <functional>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "geometry/embree_compat.h"
#include "geometry/fiber_scene.h"
#include "geometry/strand_curves.h"
#include "recorded_paths.h"

namespace tress::bench {

/// B-splines of a scene in Embree as it builds them by itself. Embree 3, whose calls these are.
class BareTree {
 public:
  explicit BareTree(const scene::Scene& scene) : device_(rtcNewDevice("")), scene_(rtcNewScene(device_)) {
    for (std::uint32_t groom = 0; groom < scene.grooms.size(); ++groom)
      curves_.push_back(geometry::strand_curves(scene, groom));
    for (const geometry::StrandCurves& curves : curves_) {
      if (curves.first_control.empty() || curves.is_linear()) continue;
      RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_FLAT_BSPLINE_CURVE);
      rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, curves.control.data(), 0,
                                 sizeof(glm::vec4), curves.control.size());
      rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, curves.first_control.data(), 0,
                                 sizeof(std::uint32_t), curves.first_control.size());
      rtcCommitGeometry(geometry);
      rtcAttachGeometry(scene_, geometry);
      rtcReleaseGeometry(geometry);
    }
    rtcJoinCommitScene(scene_);
  }
  BareTree(const BareTree&) = delete;
  BareTree& operator=(const BareTree&) = delete;
  ~BareTree() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }

  std::size_t one_by_one(std::span<const ShadowRay> rays) const {
    std::size_t met = 0;
    for (const ShadowRay& ray : rays) {
      RTCRay one = embree_ray(ray);
      geometry::embree::RayContext context;
      geometry::embree::init(&context);
      geometry::embree::occluded1(scene_, &context, &one);
      met += one.tfar < 0;
    }
    return met;
  }

#if RTC_VERSION_MAJOR < 4
  std::size_t by_eight(std::span<const ShadowRay> rays, bool coherent) const {
    std::size_t met = 0;
    for (std::size_t first = 0; first < rays.size(); first += 8) {
      RTCRay8 packet{};
      alignas(32) int valid[8];
      for (std::size_t i = 0; i < 8; ++i) {
        valid[i] = first + i < rays.size() ? -1 : 0;
        const RTCRay one = embree_ray(rays[std::min(first + i, rays.size() - 1)]);
        packet.org_x[i] = one.org_x, packet.org_y[i] = one.org_y, packet.org_z[i] = one.org_z;
        packet.dir_x[i] = one.dir_x, packet.dir_y[i] = one.dir_y, packet.dir_z[i] = one.dir_z;
        packet.tnear[i] = one.tnear, packet.tfar[i] = one.tfar, packet.mask[i] = one.mask;
      }
      geometry::embree::RayContext context = context_of(coherent);
      rtcOccluded8(valid, scene_, &context, &packet);
      for (std::size_t i = 0; i < 8; ++i) met += valid[i] != 0 && packet.tfar[i] < 0;
    }
    return met;
  }

  std::size_t in_streams(std::span<const ShadowRay> rays, bool coherent) const {
    constexpr std::size_t length = 64;
    std::size_t met = 0;
    std::vector<RTCRay> stream;
    for (std::size_t first = 0; first < rays.size(); first += length) {
      stream.clear();
      for (std::size_t i = first; i < std::min(first + length, rays.size()); ++i) stream.push_back(embree_ray(rays[i]));
      geometry::embree::RayContext context = context_of(coherent);
      rtcOccluded1M(scene_, &context, stream.data(), static_cast<unsigned int>(stream.size()), sizeof(RTCRay));
      for (const RTCRay& ray : stream) met += ray.tfar < 0;
    }
    return met;
  }
#endif

 private:
  static RTCRay embree_ray(const ShadowRay& ray) {
    RTCRay out{};
    out.org_x = ray.ray.origin.x, out.org_y = ray.ray.origin.y, out.org_z = ray.ray.origin.z;
    out.dir_x = ray.ray.direction.x, out.dir_y = ray.ray.direction.y, out.dir_z = ray.ray.direction.z;
    out.tfar = ray.distance_cm;
    out.mask = 0xFFFFFFFF;
    return out;
  }

#if RTC_VERSION_MAJOR < 4
  static geometry::embree::RayContext context_of(bool coherent) {
    geometry::embree::RayContext context;
    geometry::embree::init(&context);
    context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    return context;
  }
#endif

  RTCDevice device_;
  RTCScene scene_;
  std::vector<geometry::StrandCurves> curves_;
};

}  // namespace tress::bench
