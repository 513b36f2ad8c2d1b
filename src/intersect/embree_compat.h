// Embree 3 and 4 behind one spelling. Included by fiber_scene.cpp only.
#pragma once

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace tress::intersect::embree {

#if RTC_VERSION_MAJOR >= 4
inline void intersect1(RTCScene scene, RTCRayHit* ray_hit) { rtcIntersect1(scene, ray_hit); }
inline void occluded1(RTCScene scene, RTCRay* ray) { rtcOccluded1(scene, ray); }
#else
inline void intersect1(RTCScene scene, RTCRayHit* ray_hit) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, ray_hit);
}
inline void occluded1(RTCScene scene, RTCRay* ray) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene, &context, ray);
}
#endif

}  // namespace tress::intersect::embree
