// Scattering at fibers (FiberModel) and surfaces (surface_scattering.h) behind one interface.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "geometry/fiber_scene.h"
#include "integrate/near_hit.h"
#include "integrate/path_sums.h"
#include "integrate/surface_scattering.h"
#include "scene/model/scene.h"
#include "tress/fiber/fiber_model.h"

namespace tress::integrate {

/// A hit and the data for scattering there.
struct Vertex {
  geometry::Hit hit;
  fiber::FiberEvent event;  ///< used if the hit is on a fiber
  SurfaceMaterial surface;  ///< used if the hit is on a surface
  glm::vec3 albedo{0.0f};   ///< albedo of one scattering
  bool evaluates = true;    ///< false if no light may be sampled (FiberModel::evaluates)
  NearHit near = NearHit::no;
  int light_samples = 1, bcsdf_samples = 1;
};

/// Index of the hit's fiber in Scene::fibers. Where strands vary, the bits of the hit choose among the fibers around
/// the place and among those of the absorptions around its own. The same hit always gets the same fiber, and the mean
/// over hits interpolates between them.
std::uint32_t fiber_of(const scene::Scene& scene, const geometry::Hit& hit);

/// The object that was hit, as in scene::ObjectMarks.
inline std::uint32_t object_of(const scene::Scene& scene, const geometry::Hit& hit) {
  return hit.is_surface ? static_cast<std::uint32_t>(scene.grooms.size()) + hit.mesh : hit.groom;
}

/// Light by the layers that a vertex scatters into: the lobes of a fiber, or the surface.
using ScatteredLayers = std::array<glm::vec3, surface_layer + 1>;

inline glm::vec3 total_of(const ScatteredLayers& layers) {
  glm::vec3 total(0.0f);
  for (const glm::vec3& layer : layers) total += layer;
  return total;
}

/// Light scattered from one direction, in the vertex's own measure: dtheta dphi on a fiber, solid angle on a surface.
struct Scattered {
  ScatteredLayers layers{};  ///< S, the factor of the radiance from there
  float pdf = 0;             ///< Q, density of drawing the direction; 0 if nothing is scattered
  float solid_angle = 1;     ///< solid angle per unit of the measure: cos theta_i on a fiber, 1 on a surface
  fiber::FiberExit exit;     ///< where light leaves a fiber, if it is known
  glm::vec3 total() const { return total_of(layers); }
};

/// Immutable; any thread. All references must outlive it.
class Scattering {
 public:
  Scattering(const scene::Scene& scene, const fiber::FiberModel& model, const std::vector<fiber::FiberId>& fiber_ids);

  /// Begins the scattering at a hit. ray_direction: direction of the ray that met the hit. xi: uniforms that choose the
  /// grid node of a fiber's event. importance: as in FiberModel::begin(). near: how a fiber's event begins.
  Vertex begin(const geometry::Hit& hit, const glm::vec3& ray_direction, const std::array<float, 2>& xi,
               float importance, NearHit near = NearHit::no) const;

  /// Light scattered from a direction (unit, world, away from the hit). Counts queries in `sums`.
  Scattered evaluate(const Vertex& vertex, const glm::vec3& direction, PathSums& sums) const;

  /// An estimate of the excess of all layers together at this direction; its mean over events and `place` has no bias
  /// (FiberModel::excess). 0 for surfaces, and for models without it.
  glm::vec3 excess(const Vertex& vertex, const glm::vec3& direction, float place) const;
  bool tells_excess() const { return tells_excess_; }

  struct Sample {
    glm::vec3 direction{0, 0, 1};  ///< unit, world
    Scattered value;
  };
  /// Draws a direction. u: independent uniforms in [0, 1). Counts queries in `sums`.
  Sample sample(const Vertex& vertex, const std::array<float, 4>& u, PathSums& sums) const;

 private:
  SurfaceMaterial surface_at(const geometry::Hit& hit, const glm::vec3& ray_direction) const;

  const scene::Scene& scene_;
  const fiber::FiberModel& model_;
  const std::vector<fiber::FiberId>& fiber_ids_;
  std::vector<std::optional<Coat>> coats_;  ///< by mesh
  bool tells_excess_;
};

}  // namespace tress::integrate
