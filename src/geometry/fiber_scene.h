// Intersects rays with the strands and meshes of a scene. Only this folder includes Embree (3 or 4).
#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <limits>
#include <memory>
#include <optional>

#include "scene/model/scene.h"
#include "tress/fiber/lobes.h"

namespace tress::geometry {

inline constexpr std::uint32_t no_index = std::numeric_limits<std::uint32_t>::max();

struct Ray {
  glm::vec3 origin;
  glm::vec3 direction;  ///< unit
  /// The strand that the ray leaves, if there is one (ray_from sets both).
  std::uint32_t start_groom = no_index, start_strand = no_index;
  std::uint32_t start_instance = no_index;  ///< the instance of the groom (Hit::instance)
  bool from_camera = false;                 ///< whether it meets what the camera sees (scene::Visibility)
  float time = 0;                           ///< 0 at the opening of the shutter, 1 at its closing
  /// These two decide which strands with a presence (scene::Groom::presence) the ray hits. If `drawn` is in [0, 1), the
  /// ray hits the first strand at which the strands so far hide more than this share. If it is below 0, a hash of the
  /// key, the direction and the place decides for each stretch of a segment's length: equal rays hit the same
  /// stretches, and others are independent.
  std::uint64_t key = 0;
  float drawn = -1;
  /// For a ray that leaves a fiber: a point of the ray that arrived there, cm, before it met the fiber. A mesh between
  /// this point and the start is hit only by rays that come from this point's side, so that light stays on that side.
  std::optional<glm::vec3> came_by = {};
  /// The objects that it passes through (scene::ObjectMarks). Null: those that rays of its kind do not meet.
  const scene::ObjectMarks* passed = nullptr;
};

/// The place where a ray meets a fiber or a surface. The fields of the other kind keep their defaults.
struct Hit {
  float distance_cm;
  glm::vec3 position;  ///< on the ray; on a surface: on the triangle, to half a unit in the last place
  /// Fiber: the nearest point of its axis. Surface: the start for rays that leave, which is `position` moved along
  /// `normal` by the error of the intersection. No ray into the half space of `normal` then meets this triangle, or its
  /// neighbours in the same plane, again, and none slips through.
  glm::vec3 axis;
  /// Orthonormal, right-handed. Fiber: tangent root to tip, major axis, minor axis. Surface: w is the normal for
  /// shading, interpolated between the mesh's corners, or `normal` if the mesh has none.
  glm::vec3 u, v, w;
  std::uint32_t groom = no_index;  ///< index into Scene::grooms
  std::uint32_t strand = no_index;
  std::uint32_t instance = no_index;  ///< index into Groom::instances, or no_index if it has none
  float place = 0;                    ///< position on the strand, in segments from its root (scene::StrandSegments)
  float time = 0;                     ///< time of the ray
  std::uint64_t key = 0;              ///< key of rays that leave it, from the key and direction of the ray
  glm::vec3 came_by{0.0f};            ///< fiber: a point of the ray outside of the fiber, before it (Ray::came_by)
  glm::vec3 way{0.0f};  ///< motion of the point that was hit, from the opening of the shutter to its closing, cm
  float lateral = 0;    ///< offset along (ray direction x u) over the major semi-axis; |lateral| <= w(phi)
  /// The same over the half width w(phi) of the silhouette, in [-1, 1]: the h of fiber models, towards rising azimuth
  /// of the direction backwards.
  float share = 0;
  float semi_axis_cm = 0;  ///< major semi-axis of the fiber here
  float eccentricity = 1;  ///< minor over major semi-axis

  bool is_surface = false;
  std::uint32_t mesh = no_index;  ///< index into Scene::meshes
  std::uint32_t triangle = no_index;
  float second = 0, third = 0;  ///< weights of the triangle's second and third corner
  glm::vec3 normal{0.0f};       ///< unit, geometric, on the side that the ray came from
  /// The way from the triangle to the smooth surface that it stands for, cm; 0 where that is not known to be convex.
  glm::vec3 lift{0.0f};

  /// Whether light from this direction may reach a surface: from above its triangle or, where that stands for a convex
  /// smooth surface, from above that surface.
  bool faces(const glm::vec3& direction) const { return glm::dot(lift == glm::vec3(0.0f) ? normal : w, direction) > 0; }
};

/// The start of the ray that leaves a hit in a unit direction, cm. At a fiber it passes the axis at the same share of
/// the silhouette's half width, and on the same side, as the ray that came. This is exact for a smooth circular fiber
/// at any order, since its normals point at the axis (angular momentum), and it keeps the transport reciprocal. A ray
/// from the axis would light a dense bundle too evenly: tests/geometry/bundle_statistical_test.cpp. At a surface, a ray
/// that grazes the triangle or goes below it starts from the smooth surface (Hit::lift), so that coarse meshes have no
/// jagged edge between light and shadow.
///
/// exit: if it is known where light leaves the fiber, the ray starts where its line passes nearest to the axis, the
/// fiber taken for straight. Farther along than most_along major semi-axes, where it may have bent away, light leaves
/// there.
glm::vec3 start_of(const Hit& hit, const glm::vec3& direction, const fiber::FiberExit& exit = {});
inline constexpr float most_along = 4;

/// The ray that leaves a hit in a unit direction, at the same time. exit: as in start_of().
inline Ray ray_from(const Hit& hit, const glm::vec3& direction, const fiber::FiberExit& exit = {}) {
  Ray ray{start_of(hit, direction, exit), direction, hit.groom, hit.strand, hit.instance, false, hit.time, hit.key};
  if (!hit.is_surface) ray.came_by = hit.came_by;
  return ray;
}

/// Flat ribbons along B-splines or polygons (scene::Groom::linear), as wide as the elliptical silhouette, and two-sided
/// triangles, for camera and shadow rays alike. A ray hits a ribbon where it passes nearest to the axis, and only ahead
/// of its start. A bend of a polygon is filled on its outer side by a sector of the silhouette's width. The strand on
/// which a ray starts (Ray::start_strand) cannot be hit within two radii of the start; every other one can. A fiber
/// that lies on a mesh, or in it up to its axis, is lit like its part outside: a ray that leaves it passes the mesh
/// outwards and not inwards, even before its start (Ray::came_by). Things that move (scene::Groom::later,
/// scene::Mesh::later) are hit where they are at the ray's time. If strands have a presence, a ray hits each segment
/// with that probability, independently of the segments before it. Instances of a groom (scene::Groom::instances)
/// share its strands and their tree.
///
/// Objects may be left out for rays of a kind (scene::Visibility): rays of the camera, other rays of `intersect`, and
/// rays of `occluded`.
///
/// Built once; intersect and occluded: any thread.
class FiberScene {
 public:
  /// Builds inside the calling oneTBB arena. `scene` must outlive this. Throws std::bad_alloc if memory runs out.
  /// on_progress:
  /// called now and then with the share of the tree that is built, [0, 1], from any thread; may be empty.
  explicit FiberScene(const scene::Scene& scene, const std::function<void(double)>& on_progress = {});
  ~FiberScene();
  FiberScene(const FiberScene&) = delete;
  FiberScene& operator=(const FiberScene&) = delete;

  std::optional<Hit> intersect(const Ray& ray) const;
  /// Whether anything is hit nearer than distance_cm, by the same rules as `intersect`.
  bool occluded(const Ray& ray, float distance_cm = std::numeric_limits<float>::infinity()) const;
  std::size_t bytes() const;
  /// Whether strands have a presence; if not, no ray needs a key.
  bool has_presence() const;

 private:
  struct Implementation;
  std::optional<Hit> intersect_drawn(const Ray& ray, std::uint64_t key) const;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace tress::geometry
