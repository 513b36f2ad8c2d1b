// What paths meet and scatter on: fibers (FiberModel) and surfaces (surface_scattering.h) behind one interface.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "geometry/fiber_scene.h"
#include "integrate/path_sums.h"
#include "integrate/surface_scattering.h"
#include "scene/model/scene.h"
#include "tress/fiber/fiber_model.h"

namespace tress::integrate {

/// A hit and what scatters there.
struct Vertex {
  geometry::Hit hit;
  fiber::FiberEvent event;  ///< of a fiber
  SurfaceMaterial surface;  ///< of a surface
  glm::vec3 albedo{0.0f};   ///< of one scattering
  bool evaluates = true;    ///< false: no light may be sampled (FiberModel::evaluates)
  int light_samples = 1, bcsdf_samples = 1;
};

/// Index into Scene::fibers. Where a strand varies the bits of the hit choose among the fibers around the place: the
/// same hit is always of the same one, and the mean over hits is what lies between them.
std::uint32_t fiber_of(const scene::Scene& scene, const geometry::Hit& hit);

/// Layers that a vertex scatters into: lobes of a fiber, or the surface.
using ScatteredLayers = std::array<glm::vec3, surface_layer + 1>;

inline glm::vec3 total_of(const ScatteredLayers& layers) {
  glm::vec3 total(0.0f);
  for (const glm::vec3& layer : layers) total += layer;
  return total;
}

/// Light scattered from one direction, in the vertex's own measure: dtheta dphi on a fiber, solid angle on a surface.
struct Scattered {
  ScatteredLayers layers{};  ///< S, which the radiance from there is multiplied with
  float pdf = 0;             ///< Q, of drawing the direction; 0: nothing is scattered
  float solid_angle = 1;     ///< per unit of the measure: cos theta_i on a fiber, 1 on a surface
  glm::vec3 total() const { return total_of(layers); }
};

/// Immutable; any thread. All references must outlive it.
class Scattering {
 public:
  Scattering(const scene::Scene& scene, const fiber::FiberModel& model, const std::vector<fiber::FiberId>& fiber_ids);

  /// ray_direction: of the ray that met the hit. xi: the grid node of a fiber's event. importance: FiberModel::begin().
  /// is_near: a fiber's event begins by FiberModel::begin_near().
  Vertex begin(const geometry::Hit& hit, const glm::vec3& ray_direction, const std::array<float, 2>& xi,
               float importance, bool is_near = false) const;

  /// direction: unit, world, away from the hit. Counts queries in `sums`.
  Scattered evaluate(const Vertex& vertex, const glm::vec3& direction, PathSums& sums) const;

  /// What the sum of the layers has too much at this direction, in the mean over events and `place`
  /// (FiberModel::excess): 0 of surfaces, and where the model does not tell.
  glm::vec3 excess(const Vertex& vertex, const glm::vec3& direction, float place) const;
  bool tells_excess() const { return tells_excess_; }

  struct Sample {
    glm::vec3 direction{0, 0, 1};  ///< unit, world
    Scattered value;
  };
  /// u: independent uniforms in [0, 1).
  Sample sample(const Vertex& vertex, const std::array<float, 4>& u, PathSums& sums) const;

 private:
  SurfaceMaterial surface_at(const geometry::Hit& hit, const glm::vec3& ray_direction) const;

  const scene::Scene& scene_;
  const fiber::FiberModel& model_;
  const std::vector<fiber::FiberId>& fiber_ids_;
  std::vector<std::optional<Coat>> coats_;  ///< of the meshes
  bool tells_excess_;
};

}  // namespace tress::integrate
