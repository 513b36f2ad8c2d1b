#include "geometry/fiber_scene.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <limits>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include "geometry/embree_compat.h"
#include "geometry/strand_curves.h"
#include "geometry/surface_hits.h"
#include "scene/model/groom_bounds.h"
#include "tress/base/random.h"

namespace tress::geometry {
namespace {

/// A stretch of a strand, from a place on one segment to the same place on the next, that is present or absent as a
/// whole. Pieces of a ribbon overlap at the inner side of a bend, where a ray may meet both, so a cell ends in the
/// middle of a piece. instance: Embree's id, or RTC_INVALID_GEOMETRY_ID if the groom has none.
struct Cell {
  std::uint32_t groom, instance, strand, index;
  Cell(const StrandCurves& curves, std::uint32_t instance_id, std::uint32_t segment, float t)
      : groom(curves.groom),
        instance(instance_id),
        strand(curves.segments[segment].strand),
        index(t < end(float(curves.pieces)) ? segment : segment + 1) {}
  /// The middle of the piece that 0.625 of the segment lies in.
  static float end(float pieces) { return (std::floor(0.625f * pieces) + 0.5f) / pieces; }
  friend bool operator==(const Cell&, const Cell&) = default;
};

/// The hits of a ray on strands with a presence, in any order, as far as they are needed.
class DrawnHits {
 public:
  explicit DrawnHits(float drawn) : drawn_(drawn) {}

  /// Adds a hit. Returns whether the ray ends there at the latest.
  bool add(const RTCHit& hit, const Cell& cell, float distance, float presence) {
    const auto same = std::ranges::find(all_, cell, &Entry::cell);
    const Entry entry{hit, cell, distance, presence};
    if (same == all_.end())
      all_.push_back(entry);
    else if (distance < same->distance)
      *same = entry;
    float let_through = 1;
    for (const Entry& other : all_) let_through *= other.distance <= distance ? 1 - other.presence : 1;
    if (!(1 - let_through > drawn_)) return false;
    std::erase_if(all_, [&](const Entry& other) { return other.distance > distance; });
    return true;
  }
  /// The hit that is drawn up to `limit`, with its distance; null if no hit is drawn.
  const RTCHit* choose(float limit, float* distance) {
    std::ranges::sort(all_, {}, &Entry::distance);
    float let_through = 1;
    for (const Entry& entry : all_) {
      if (entry.distance > limit) break;
      let_through *= 1 - entry.presence;
      if (!(1 - let_through > drawn_)) continue;
      *distance = entry.distance;
      return &entry.hit;
    }
    return nullptr;
  }

 private:
  struct Entry {
    RTCHit hit;
    Cell cell;
    float distance, presence;
  };
  float drawn_;
  std::vector<Entry> all_;
};

/// The instances of all grooms by Embree's ids, which are consecutive.
struct Instances {
  struct Entry {
    std::uint32_t groom, index;
    const scene::Instance* instance;
  };
  std::uint32_t first_id = 0;
  std::vector<Entry> all = {};
  std::vector<std::uint32_t> first_of_groom = {};  ///< Embree's id of its first one, or RTC_INVALID_GEOMETRY_ID

  /// The scale of an instance. id: Embree's, or RTC_INVALID_GEOMETRY_ID, which is not scaled.
  float scale(std::uint32_t id, float time) const {
    if (id == RTC_INVALID_GEOMETRY_ID) return 1;
    const scene::Instance& instance = *all[id - first_id].instance;
    return instance.later.empty() ? instance.first.scale : instance.at(time).scale;
  }
};

/// The data of a ray for the filter. Embree passes a pointer to the first member.
struct RayQuery {
  embree::RayContext context;
  std::uint32_t start_groom, start_instance, first_own, own_count;  ///< the segments of the strand that the ray leaves
  const Instances* instances;
  float start;                 ///< distance from Embree's origin to where the ray starts
  const std::uint8_t* passed;  ///< scene::ObjectMarks by geometry; null: it passes nothing
  float time;
  std::uint64_t key;                   ///< decides which segments with a presence are hit
  const glm::vec3* came_by = nullptr;  ///< Ray::came_by of a ray that leaves a fiber
  DrawnHits* drawn = nullptr;          ///< the hits of a ray that draws from front to back (Ray::drawn)
};

/// Whether the ray hits the segment there. The result does not depend on the order of the segments.
bool is_met(const StrandCurves& curves, std::uint32_t instance, std::uint32_t segment, float t, std::uint64_t key) {
  const Cell cell(curves, instance, segment, t);
  const std::uint64_t own_key = instance == RTC_INVALID_GEOMETRY_ID ? key : RandomStream(key, instance).next_bits();
  return RandomStream(own_key, std::uint64_t{cell.groom} << 32 | cell.strand, cell.index).next() <
         curves.presence(segment, t);
}

/// Embree's id of the instance that was hit, or RTC_INVALID_GEOMETRY_ID.
std::uint32_t instance_of(const RTCFilterFunctionNArguments* arguments, unsigned int i) {
  return RTCHitN_instID(arguments->hit, arguments->N, i, 0);
}

/// Whether a ray that draws from front to back ends there at the latest.
bool ends_at(const StrandCurves& curves, const RTCFilterFunctionNArguments* arguments, unsigned int i,
             DrawnHits& drawn) {
  const unsigned int n = arguments->N;
  RTCHit hit{};
  hit.primID = RTCHitN_primID(arguments->hit, n, i);
  hit.geomID = curves.groom;
  hit.instID[0] = instance_of(arguments, i);
  hit.u = RTCHitN_u(arguments->hit, n, i);
  hit.v = RTCHitN_v(arguments->hit, n, i);
  hit.Ng_x = RTCHitN_Ng_x(arguments->hit, n, i);
  hit.Ng_y = RTCHitN_Ng_y(arguments->hit, n, i);
  hit.Ng_z = RTCHitN_Ng_z(arguments->hit, n, i);
  return drawn.add(hit, Cell(curves, hit.instID[0], hit.primID, hit.u), RTCRayN_tfar(arguments->ray, n, i),
                   curves.presence(hit.primID, hit.u));
}

std::uint64_t key_of(const Ray& ray) {
  const glm::vec3& direction = ray.direction;
  return RandomStream(ray.key, bits_of(direction.x, direction.y), bits_of(direction.z, ray.time)).next_bits();
}

/// w(phi) of a ray across a fiber, phi its azimuth about (major, minor): w^2 = (e^2 d_v^2 + d_w^2) / (d_v^2 + d_w^2).
float half_width(const glm::vec3& direction, const glm::vec3& major_axis, const glm::vec3& minor_axis, float e) {
  const float major = glm::dot(direction, major_axis), minor = glm::dot(direction, minor_axis);
  const float across = major * major + minor * minor;
  return across > 0 ? std::sqrt((e * e * major * major + minor * minor) / across) : 1.0f;
}

/// Whether the hit on the circumscribed ribbon lies outside the ellipse's silhouette: |v| > w(phi), phi the azimuth of
/// the ray in the local frame. A ray along the tangent has no azimuth and counts as inside.
bool is_outside(const StrandCurves& curves, std::uint32_t segment, float along, float lateral, const glm::vec3& slope,
                const glm::vec3& direction, float time) {
  if (std::abs(lateral) <= curves.least_eccentricity) return false;  // inside, as below, without reading the segment
  const float eccentricity = curves.segments[segment].eccentricity;
  if (std::abs(lateral) <= eccentricity) return false;  // w >= e: inside from every direction
  const FiberFrame frame = curves.frame(segment, along, glm::normalize(slope), time);
  // w^2 = (e^2 d_v^2 + d_w^2) / (d_v^2 + d_w^2)
  const float major = glm::dot(direction, frame.v) * glm::dot(direction, frame.v);
  const float minor = glm::dot(direction, frame.w) * glm::dot(direction, frame.w);
  return lateral * lateral * (major + minor) > eccentricity * eccentricity * major + minor;
}

glm::vec3 slope_of(const RTCFilterFunctionNArguments* arguments, unsigned int i) {
  const unsigned int n = arguments->N;
  return {RTCHitN_Ng_x(arguments->hit, n, i), RTCHitN_Ng_y(arguments->hit, n, i), RTCHitN_Ng_z(arguments->hit, n, i)};
}

glm::vec3 direction_of(const RTCFilterFunctionNArguments* arguments, unsigned int i) {
  const unsigned int n = arguments->N;
  return {RTCRayN_dir_x(arguments->ray, n, i), RTCRayN_dir_y(arguments->ray, n, i),
          RTCRayN_dir_z(arguments->ray, n, i)};
}

glm::vec3 origin_of(const RTCFilterFunctionNArguments* arguments, unsigned int i) {
  const unsigned int n = arguments->N;
  return {RTCRayN_org_x(arguments->ray, n, i), RTCRayN_org_y(arguments->ray, n, i),
          RTCRayN_org_z(arguments->ray, n, i)};
}

/// The same for linear strands. Embree reports v = 0 for them and ends every segment in a round cap, so the lateral
/// offset is computed here, and a hit on a cap counts only if it joins a bend.
bool is_outside_linear(const StrandCurves& curves, const RTCFilterFunctionNArguments* arguments, unsigned int i,
                       float time) {
  const unsigned int n = arguments->N;
  const std::uint32_t segment = RTCHitN_primID(arguments->hit, n, i);
  const float along = RTCHitN_u(arguments->hit, n, i);
  const bool is_cap = along <= 0 || along >= 1;
  if (!is_cap && !curves.elliptical()) return false;
  const glm::vec3 direction = direction_of(arguments, i);
  const glm::vec3 position = origin_of(arguments, i) + RTCRayN_tfar(arguments->ray, n, i) * direction;
  if (is_cap && !curves.is_in_joint(segment, along, position, direction, time)) return true;
  if (!curves.elliptical()) return false;
  const float lateral =
      glm::distance(position, curves.axis(segment, along, time)) / curves.semi_axis(segment, along, time);
  return is_outside(curves, segment, along, lateral, slope_of(arguments, i), direction, time);
}

/// Rejects hits outside the silhouette, hits on the strand that the ray leaves within two radii of its start, and all
/// hits on a groom that the ray passes.
void fiber_filter(const RTCFilterFunctionNArguments* arguments) {
  const auto& curves = *static_cast<const StrandCurves*>(arguments->geometryUserPtr);
  const auto& query = *reinterpret_cast<const RayQuery*>(arguments->context);
  const unsigned int n = arguments->N;
  for (unsigned int i = 0; i < n; ++i) {
    if (arguments->valid[i] == 0) continue;
    const std::uint32_t segment = RTCHitN_primID(arguments->hit, n, i);
    const float along = RTCHitN_u(arguments->hit, n, i);
    const bool is_passed = query.passed != nullptr && query.passed[curves.groom] != 0;
    const bool is_before_start = RTCRayN_tfar(arguments->ray, n, i) < query.start;  // where it looks for meshes only
    if (is_passed || is_before_start) {
      arguments->valid[i] = 0;
      continue;
    }
    const std::uint32_t instance = instance_of(arguments, i);
    const bool is_own = curves.groom == query.start_groom && instance == query.start_instance &&
                        segment - query.first_own < query.own_count;
    const auto two_radii = [&] {
      return 2 * query.instances->scale(instance, query.time) * curves.semi_axis(segment, along, query.time);
    };
    if (is_own && RTCRayN_tfar(arguments->ray, n, i) - query.start < two_radii()) {
      arguments->valid[i] = 0;
    } else if (curves.is_linear()) {
      if (is_outside_linear(curves, arguments, i, query.time)) arguments->valid[i] = 0;
    } else if (curves.elliptical()) {
      if (is_outside(curves, segment, along, RTCHitN_v(arguments->hit, n, i), slope_of(arguments, i),
                     direction_of(arguments, i), query.time)) {
        arguments->valid[i] = 0;
      }
    }
    if (!curves.is_sparse || arguments->valid[i] == 0) continue;
    const bool is_there = query.drawn != nullptr ? ends_at(curves, arguments, i, *query.drawn)
                                                 : is_met(curves, instance, segment, along, query.key);
    if (!is_there) arguments->valid[i] = 0;
  }
}

/// Whether a ray that leaves a fiber meets the mesh from within, on its way to the side from which light came to it.
bool is_from_within(const RTCFilterFunctionNArguments* arguments, unsigned int i, const glm::vec3& came_by) {
  const glm::vec3 normal = slope_of(arguments, i), direction = direction_of(arguments, i);
  const glm::vec3 point = origin_of(arguments, i) + RTCRayN_tfar(arguments->ray, arguments->N, i) * direction;
  return glm::dot(normal, direction) * glm::dot(normal, came_by - point) > 0;
}

/// Rejects hits on meshes that the ray passes, and hits from within of rays that leave a fiber.
void mesh_filter(const RTCFilterFunctionNArguments* arguments) {
  const auto& query = *reinterpret_cast<const RayQuery*>(arguments->context);
  for (unsigned int i = 0; i < arguments->N; ++i) {
    if (arguments->valid[i] == 0) continue;
    const bool is_passed =
        query.passed != nullptr && query.passed[RTCHitN_geomID(arguments->hit, arguments->N, i)] != 0;
    if (is_passed || (query.came_by != nullptr && is_from_within(arguments, i, *query.came_by)))
      arguments->valid[i] = 0;
  }
}

bool count_bytes(void* user, ssize_t bytes, bool) {
  *static_cast<std::atomic<std::ptrdiff_t>*>(user) += bytes;
  return true;
}

/// Embree ignores ribbons within two radii of a ray's origin. So Embree's origin lies that far behind ours, and tnear
/// excludes what is nearer than our start, except for a ray that leaves a fiber, which may be in a mesh there.
RTCRay embree_ray(const Ray& ray, float start, bool has_meshes) {
  const glm::vec3 origin = ray.origin - start * ray.direction;
  RTCRay out{};
  out.org_x = origin.x;
  out.org_y = origin.y;
  out.org_z = origin.z;
  out.dir_x = ray.direction.x;
  out.dir_y = ray.direction.y;
  out.dir_z = ray.direction.z;
  out.tnear = ray.came_by && has_meshes ? 0 : start;
  out.tfar = std::numeric_limits<float>::infinity();
  out.mask = 0xFFFFFFFF;
  out.time = ray.time;
  return out;
}

RTCRayHit unmet(const Ray& ray, float start, bool has_meshes) {
  RTCRayHit found{};
  found.ray = embree_ray(ray, start, has_meshes);
  found.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  found.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  return found;
}

/// key: the ray's key; it is not used if no strand has a presence. unseen: by rays of its kind.
RayQuery ray_query(const Ray& ray, const std::vector<StrandCurves>& grooms, const Instances& instances, float start,
                   std::uint64_t key, const scene::ObjectMarks& unseen) {
  RayQuery query;
  query.instances = &instances;
  query.start_instance = ray.start_instance == no_index || ray.start_groom >= grooms.size()
                             ? RTC_INVALID_GEOMETRY_ID
                             : instances.first_of_groom[ray.start_groom] + ray.start_instance;
  query.key = key;
  embree::init(&query.context);
  query.start_groom = ray.start_groom;
  query.first_own = query.own_count = 0;
  if (ray.start_groom < grooms.size() && ray.start_strand != no_index) {
    const std::uint32_t* first = &grooms[ray.start_groom].first_segment[ray.start_strand];
    query.first_own = first[0];
    query.own_count = first[1] - first[0];
  }
  query.start = start;
  const scene::ObjectMarks& passed = ray.passed != nullptr ? *ray.passed : unseen;
  query.passed = passed.empty() ? nullptr : passed.data();
  query.time = ray.time;
  if (ray.came_by) query.came_by = &*ray.came_by;
  return query;
}

/// Moves a hit from the coordinates of a groom to those of the scene.
void place(const scene::Instance& instance, Hit* hit) {
  const scene::Similarity now = instance.at(hit->time);
  if (!instance.later.empty()) {
    const glm::vec3 opening = hit->axis - hit->time * hit->way, closing = opening + hit->way;
    hit->way = instance.later.back().point(closing) - instance.first.point(opening);
  } else {
    hit->way = now.scale * (now.turn * hit->way);
  }
  hit->distance_cm *= now.scale;
  hit->axis = now.point(hit->axis);
  hit->semi_axis_cm *= now.scale;
  for (glm::vec3* axis : {&hit->u, &hit->v, &hit->w}) *axis = now.turn * *axis;
}

/// ray: in the coordinates of the groom.
Hit fiber_hit(const StrandCurves& curves, const Ray& ray, float distance_cm, const RTCHit& found) {
  const glm::vec3 along(found.Ng_x, found.Ng_y, found.Ng_z);  // 0 if control points coincide at an end
  const glm::vec3 tangent = glm::length(along) > 0 ? glm::normalize(along) : glm::vec3(0, 0, 1);
  const FiberFrame frame = curves.frame(found.primID, found.u, tangent, ray.time);
  Hit hit;
  hit.distance_cm = distance_cm;
  hit.position = ray.origin + distance_cm * ray.direction;
  const glm::vec3 side = glm::cross(ray.direction, frame.u);
  const float sine = glm::length(side);
  const float semi_axis = curves.semi_axis(found.primID, found.u, ray.time);
  if (curves.is_linear()) {
    hit.axis = curves.axis(found.primID, found.u, ray.time);
    const float offset = sine > 1e-6f ? glm::dot(hit.position - hit.axis, side) / sine : 0.0f;
    hit.lateral = semi_axis > 0 ? std::clamp(offset / semi_axis, -1.0f, 1.0f) : 0.0f;
  } else {
    hit.axis = sine > 1e-6f ? hit.position - (found.v * semi_axis / sine) * side : hit.position;
    hit.lateral = found.v;
  }
  hit.semi_axis_cm = semi_axis;
  hit.eccentricity = curves.segments[found.primID].eccentricity;
  hit.share = std::clamp(hit.lateral / half_width(ray.direction, frame.v, frame.w, hit.eccentricity), -1.0f, 1.0f);
  hit.u = frame.u;
  hit.v = frame.v;
  hit.w = frame.w;
  hit.groom = curves.groom;
  hit.strand = curves.segments[found.primID].strand;
  hit.place = curves.segments[found.primID].place_at(found.u);
  hit.time = ray.time;
  hit.came_by = hit.position - std::min(distance_cm, sine > 0 ? semi_axis / sine : distance_cm) * ray.direction;
  hit.way = curves.way(found.primID, found.u);
  return hit;
}

/// A mesh and the data that its hits need.
struct Surface {
  const scene::Mesh* mesh;
  std::uint32_t index;
  float extent_cm;
};

Hit surface_hit(const Surface& surface, const Ray& ray, float distance_cm, const RTCHit& found) {
  const scene::Mesh& mesh = *surface.mesh;
  const SurfacePoint point = surface_point(mesh, found.primID, found.u, found.v, surface.extent_cm, ray.time);
  Hit hit;
  hit.distance_cm = distance_cm;
  hit.position = point.position;
  hit.normal = glm::dot(point.normal, ray.direction) > 0 ? -point.normal : point.normal;
  hit.axis = point.position + point.offset_cm * hit.normal;
  hit.w = shading_normal(mesh, found.primID, found.u, found.v, hit.normal, ray.direction, ray.time);
  hit.u = root_normal(hit.w);
  hit.v = glm::cross(hit.w, hit.u);
  if (hit.w != hit.normal) hit.lift = way_to_smooth(mesh, found.primID, found.u, found.v, hit.normal, ray.time);
  hit.is_surface = true;
  hit.mesh = surface.index;
  hit.triangle = found.primID;
  hit.second = found.u;
  hit.third = found.v;
  hit.time = ray.time;
  if (!mesh.later.empty()) hit.way = surface_way(mesh, found.primID, found.u, found.v);
  return hit;
}

/// Throws if Embree has failed, mostly for lack of memory, which it reports on request only. `made`: its result.
void check(RTCDevice device, const void* made) {
  const RTCError error = rtcGetDeviceError(device);  // without a device: the error of this thread
  if (made != nullptr && error == RTC_ERROR_NONE) return;
  if (device == nullptr || error == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
  throw std::runtime_error("Embree: error " + std::to_string(static_cast<int>(error)));
}

RTCGeometry ribbons(RTCDevice device, StrandCurves* curves) {
  RTCGeometry geometry =
      rtcNewGeometry(device, curves->is_linear()                           ? RTC_GEOMETRY_TYPE_FLAT_LINEAR_CURVE
                             : curves->basis == scene::StrandBasis::bezier ? RTC_GEOMETRY_TYPE_FLAT_BEZIER_CURVE
                                                                           : RTC_GEOMETRY_TYPE_FLAT_BSPLINE_CURVE);
  check(device, geometry);
  rtcSetGeometryTessellationRate(geometry, static_cast<float>(curves->pieces));
  rtcSetGeometryTimeStepCount(geometry, static_cast<unsigned int>(curves->moments()));
  const auto share = [&](unsigned int moment, const std::vector<glm::vec4>& control) {
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, moment, RTC_FORMAT_FLOAT4, control.data(), 0,
                               sizeof(glm::vec4), control.size());
  };
  share(0, curves->control);
  for (unsigned int moment = 1; moment < curves->moments(); ++moment) share(moment, curves->later_control[moment - 1]);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, curves->first_control.data(), 0,
                             sizeof(std::uint32_t), curves->first_control.size());
  rtcSetGeometryUserData(geometry, curves);
  rtcSetGeometryIntersectFilterFunction(geometry, fiber_filter);
  rtcSetGeometryOccludedFilterFunction(geometry, fiber_filter);
  return geometry;
}

RTCGeometry triangles(RTCDevice device, const scene::Mesh& mesh) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  check(device, geometry);
  // Embree reads 16 bytes at every corner; it pads the buffers that it allocates itself.
  rtcSetGeometryTimeStepCount(geometry, static_cast<unsigned int>(1 + mesh.later.size()));
  const auto copy = [&](RTCBufferType type, RTCFormat format, const auto& items, unsigned int moment) {
    const std::size_t size = sizeof(items.front());
    void* buffer = rtcSetNewGeometryBuffer(geometry, type, moment, format, size, items.size());
    check(device, buffer);
    std::memcpy(buffer, items.data(), items.size() * size);
  };
  copy(RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, mesh.positions, 0);
  unsigned int moment = 0;
  for (const scene::MeshMoment& later : mesh.later)
    copy(RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, later.positions, ++moment);
  copy(RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, mesh.triangles, 0);
  rtcSetGeometryIntersectFilterFunction(geometry, mesh_filter);
  rtcSetGeometryOccludedFilterFunction(geometry, mesh_filter);
  return geometry;
}

/// Other flags and qualities make rays slower (bench/README.md, rays). Of rays aimed at an edge that two triangles
/// share, 3.5 % slip through without the robust flag, and 0.007 % with it.
RTCScene new_scene(RTCDevice device, bool has_meshes) {
  const RTCScene scene = rtcNewScene(device);
  check(device, scene);
  rtcSetSceneFlags(scene, has_meshes ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
  return scene;
}

/// An instance of a groom's scene.
RTCGeometry placed(RTCDevice device, RTCScene scene, const scene::Instance& instance) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
  check(device, geometry);
  rtcSetGeometryInstancedScene(geometry, scene);
  rtcSetGeometryTimeStepCount(geometry, static_cast<unsigned int>(1 + instance.later.size()));
  const auto set = [&](unsigned int moment, const scene::Similarity& place) {
    const glm::mat3 linear = place.scale * place.turn;
    const std::array<glm::vec3, 4> columns{linear[0], linear[1], linear[2], place.offset};
    rtcSetGeometryTransform(geometry, moment, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns.data());
  };
  set(0, instance.first);
  for (std::size_t moment = 0; moment < instance.later.size(); ++moment)
    set(static_cast<unsigned int>(moment + 1), instance.later[moment]);
  return geometry;
}

void attach(RTCScene scene, RTCGeometry geometry, std::size_t index) {
  rtcSetGeometryMask(geometry, 0xFFFFFFFF);
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene, geometry, static_cast<unsigned int>(index));
  rtcReleaseGeometry(geometry);
}

}  // namespace

glm::vec3 start_of(const Hit& hit, const glm::vec3& direction, const fiber::FiberExit& exit) {
  if (hit.is_surface) {
    constexpr float grazing = 0.1f;  // cosine about the triangle's normal from which on the start is its own
    return hit.axis + std::clamp(1 - glm::dot(hit.normal, direction) / grazing, 0.0f, 1.0f) * hit.lift;
  }
  const glm::vec3 side = glm::cross(direction, hit.u);
  const float sine = glm::length(side);
  if (exit.is_known) {
    const glm::vec3 axis = hit.axis + (std::clamp(exit.along, -most_along, most_along) * hit.semi_axis_cm) * hit.u;
    return sine > 1e-6f ? axis + (exit.across * hit.semi_axis_cm / sine) * side : axis;
  }
  if (!(sine > 1e-6f)) return hit.axis;
  return hit.axis +
         (hit.share * hit.semi_axis_cm * half_width(direction, hit.v, hit.w, hit.eccentricity) / sine) * side;
}

/// Embree's geometries: the grooms by index, then the meshes, then the instances of grooms. A groom with instances is
/// in a scene of its own, and has no geometry of its index.
struct FiberScene::Implementation {
  Implementation() = default;
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;
  ~Implementation() {  // also needed for a scene whose construction failed
    if (scene != nullptr) rtcReleaseScene(scene);
    if (device != nullptr) rtcReleaseDevice(device);
  }

  std::atomic<std::ptrdiff_t> embree_bytes{0};
  std::vector<StrandCurves> grooms;  ///< Embree and the filter point to these: they must not move
  std::vector<Surface> surfaces;
  Instances instances;
  /// The hit on a fiber of a groom, or of an instance of it.
  Hit on_fiber(const Ray& ray, float distance_cm, const RTCHit& found) const {
    if (found.instID[0] == RTC_INVALID_GEOMETRY_ID) return fiber_hit(grooms[found.geomID], ray, distance_cm, found);
    const Instances::Entry& entry = instances.all[found.instID[0] - instances.first_id];
    const scene::Similarity now = entry.instance->at(ray.time);
    Ray local = ray;
    local.origin = now.local_point(ray.origin);
    local.direction = glm::normalize(ray.direction * now.turn);
    Hit hit = fiber_hit(grooms[entry.groom], local, distance_cm / now.scale, found);
    const glm::vec3 back = hit.position - hit.came_by;
    place(*entry.instance, &hit);
    hit.position = ray.origin + distance_cm * ray.direction;
    hit.came_by = hit.position - now.scale * glm::length(back) * ray.direction;
    hit.distance_cm = distance_cm;
    hit.instance = entry.index;
    return hit;
  }
  /// Converts the hit that Embree found; empty if it found none. key: the key of rays that leave the hit.
  std::optional<Hit> hit(const Ray& ray, const RTCRayHit& found, std::uint64_t key) const {
    if (found.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
    const float distance_cm = std::max(found.ray.tfar - start, 0.0f);
    const bool is_instance = found.hit.instID[0] != RTC_INVALID_GEOMETRY_ID;
    Hit hit = is_instance || found.hit.geomID < grooms.size()
                  ? on_fiber(ray, distance_cm, found.hit)
                  : surface_hit(surfaces[found.hit.geomID - grooms.size()], ray, distance_cm, found.hit);
    hit.key = key;
    return hit;
  }

  /// Builds the tree of a groom, once, and adds its instances to the scene.
  void add_instances(const scene::Groom& groom, std::uint32_t index, bool has_meshes) {
    const RTCScene own = new_scene(device, has_meshes);
    attach(own, ribbons(device, &grooms[index]), 0);
    rtcJoinCommitScene(own);
    instances.first_of_groom[index] = static_cast<std::uint32_t>(instances.first_id + instances.all.size());
    for (std::uint32_t i = 0; i < groom.instances.size(); ++i) {
      attach(scene, placed(device, own, groom.instances[i]), instances.first_id + instances.all.size());
      instances.all.push_back({index, i, &groom.instances[i]});
    }
    rtcReleaseScene(own);  // its instances keep it
    check(device, scene);
  }

  const scene::ObjectMarks& unseen(const Ray& ray) const {
    return ray.from_camera ? unseen_by_camera : unseen_indirectly;
  }

  scene::ObjectMarks unseen_by_camera, unseen_indirectly, without_shadow;
  bool sparse = false;  ///< whether strands of some groom have a presence
  float start = 0;      ///< distance of Embree's origin behind a ray's, cm
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
};

FiberScene::FiberScene(const scene::Scene& scene, const std::function<void(double)>& on_progress)
    : implementation_(std::make_unique<Implementation>()) {
  Implementation& self = *implementation_;
  self.device = rtcNewDevice(nullptr);
  check(self.device, self.device);
  rtcSetDeviceMemoryMonitorFunction(self.device, count_bytes, &self.embree_bytes);
  self.scene = new_scene(self.device, !scene.meshes.empty());
  self.unseen_by_camera = scene::marked_objects(scene, [](const auto& object) { return !object.visibility.camera; });
  self.unseen_indirectly = scene::marked_objects(scene, [](const auto& object) { return !object.visibility.indirect; });
  self.without_shadow = scene::marked_objects(scene, [](const auto& object) { return !object.visibility.shadow; });
  self.grooms.reserve(scene.grooms.size());
  float largest_axis = 0;
  for (std::uint32_t index = 0; index < scene.grooms.size(); ++index) {
    self.grooms.push_back(strand_curves(scene, index));
    StrandCurves& curves = self.grooms.back();
    if (curves.first_control.empty()) continue;
    self.sparse = self.sparse || curves.is_sparse;
    const float scale = scene::largest_scale(scene.grooms[index]);
    for (const glm::vec4& control : curves.control) largest_axis = std::max(largest_axis, scale * control.w);
    for (const auto& moment : curves.later_control)
      for (const glm::vec4& control : moment) largest_axis = std::max(largest_axis, scale * control.w);
    if (scene.grooms[index].instances.empty()) attach(self.scene, ribbons(self.device, &curves), index);
  }
  self.start = 2.01f * largest_axis;
  for (std::uint32_t index = 0; index < scene.meshes.size(); ++index) {
    const scene::Mesh& mesh = scene.meshes[index];
    self.surfaces.push_back({&mesh, index, largest_coordinate(mesh)});
    if (!mesh.triangles.empty()) attach(self.scene, triangles(self.device, mesh), scene.grooms.size() + index);
  }
  self.instances.first_id = static_cast<std::uint32_t>(scene.grooms.size() + scene.meshes.size());
  self.instances.first_of_groom.assign(scene.grooms.size(), RTC_INVALID_GEOMETRY_ID);
  for (std::uint32_t index = 0; index < scene.grooms.size(); ++index)
    if (!scene.grooms[index].instances.empty() && !self.grooms[index].first_control.empty())
      self.add_instances(scene.grooms[index], index, !scene.meshes.empty());
  // Embree calls it from any thread; it returns true to continue.
  const auto monitor = [](void* listener, double share) {
    (*static_cast<const std::function<void(double)>*>(listener))(share);
    return true;
  };
  if (on_progress)
    rtcSetSceneProgressMonitorFunction(self.scene, monitor, const_cast<std::function<void(double)>*>(&on_progress));
  rtcJoinCommitScene(self.scene);
  if (on_progress) rtcSetSceneProgressMonitorFunction(self.scene, nullptr, nullptr);
  check(self.device, self.scene);
}

FiberScene::~FiberScene() = default;

std::optional<Hit> FiberScene::intersect(const Ray& ray) const {
  const Implementation& self = *implementation_;
  const std::uint64_t key = self.sparse ? key_of(ray) : 0;
  if (self.sparse && ray.drawn >= 0) return intersect_drawn(ray, key);
  RayQuery query = ray_query(ray, self.grooms, self.instances, self.start, key, self.unseen(ray));
  RTCRayHit found = unmet(ray, self.start, !self.surfaces.empty());
  embree::intersect1(self.scene, &query.context, &found);
  return self.hit(ray, found, key);
}

std::optional<Hit> FiberScene::intersect_drawn(const Ray& ray, std::uint64_t key) const {
  const Implementation& self = *implementation_;
  RayQuery query = ray_query(ray, self.grooms, self.instances, self.start, key, self.unseen(ray));
  DrawnHits drawn(ray.drawn);
  query.drawn = &drawn;
  RTCRayHit found = unmet(ray, self.start, !self.surfaces.empty());
  embree::intersect1(self.scene, &query.context, &found);
  if (const RTCHit* hit = drawn.choose(found.ray.tfar, &found.ray.tfar)) found.hit = *hit;
  return self.hit(ray, found, key);
}

bool FiberScene::has_presence() const { return implementation_->sparse; }

bool FiberScene::occluded(const Ray& ray, float distance_cm) const {
  const Implementation& self = *implementation_;
  RayQuery query =
      ray_query(ray, self.grooms, self.instances, self.start, self.sparse ? key_of(ray) : 0, self.without_shadow);
  RTCRay shadow = embree_ray(ray, self.start, !self.surfaces.empty());
  shadow.tfar = self.start + distance_cm;
  embree::occluded1(self.scene, &query.context, &shadow);
  return shadow.tfar < 0;
}

std::size_t FiberScene::bytes() const {
  std::size_t total = static_cast<std::size_t>(implementation_->embree_bytes.load());
  for (const StrandCurves& curves : implementation_->grooms) total += curves.bytes();
  return total;
}

}  // namespace tress::geometry
