// Rays against the strands of a scene. The only folder that includes Embree (3 or 4).
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>

#include "scene/scene.h"

namespace tress::intersect {

struct Ray {
  glm::vec3 origin;
  glm::vec3 direction;  ///< unit
};

struct Hit {
  float distance_cm;
  glm::vec3 position;   ///< on the ray
  glm::vec3 axis;       ///< nearest point of the fiber's axis: rays that leave the fiber start here (below)
  glm::vec3 u, v, w;    ///< fiber frame: tangent root to tip, major axis, minor axis; orthonormal, right-handed
  std::uint32_t groom;  ///< index into Scene::grooms
  std::uint32_t strand;
  float lateral;  ///< offset along (ray direction x u) over the major semi-axis; |lateral| <= w(phi)
};

/// A ray that starts on the axis does not meet its own fiber where that is straight: Embree ignores a flat curve
/// within two radii of the ray's start, and the ribbon faces the ray. Started at `position`, 1.1 % of isotropic rays,
/// those close to the tangent, hit their own fiber a second time.
///
/// Flat B-spline ribbons as wide as the elliptical silhouette, for camera and shadow rays alike.
/// Built once; intersect and occluded: any thread.
class FiberScene {
 public:
  /// Builds inside the calling oneTBB arena. `scene` must outlive this.
  explicit FiberScene(const scene::Scene& scene);
  ~FiberScene();
  FiberScene(const FiberScene&) = delete;
  FiberScene& operator=(const FiberScene&) = delete;

  std::optional<Hit> intersect(const Ray& ray) const;
  bool occluded(const Ray& ray) const;
  std::size_t bytes() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace tress::intersect
