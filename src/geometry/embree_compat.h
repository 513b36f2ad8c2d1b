// One spelling for Embree 3 and 4. Only the .cpp files of this folder include it.
#pragma once

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace tress::geometry::embree {

#if RTC_VERSION_MAJOR >= 4
using RayContext = RTCRayQueryContext;
inline void init(RayContext* context) { rtcInitRayQueryContext(context); }
inline void intersect1(RTCScene scene, RayContext* context, RTCRayHit* ray_hit) {
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.context = context;
  rtcIntersect1(scene, ray_hit, &arguments);
}
inline void occluded1(RTCScene scene, RayContext* context, RTCRay* ray) {
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.context = context;
  rtcOccluded1(scene, ray, &arguments);
}
#else
using RayContext = RTCIntersectContext;
inline void init(RayContext* context) { rtcInitIntersectContext(context); }
inline void intersect1(RTCScene scene, RayContext* context, RTCRayHit* ray_hit) {
  rtcIntersect1(scene, context, ray_hit);
}
inline void occluded1(RTCScene scene, RayContext* context, RTCRay* ray) { rtcOccluded1(scene, context, ray); }
#endif

}  // namespace tress::geometry::embree
