// What the paths of a pixel bring: radiance by layer, what the first hit is like, queries of the table.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>

#include "tress/fiber/lobes.h"

namespace tress::integrate {

/// Layers of a picture: the lobe of the first fiber hit, then surfaces first hit, then what is behind everything.
constexpr std::size_t surface_layer = fiber::lobe_count, background_layer = surface_layer + 1,
                      layer_count = background_layer + 1;
constexpr const char* layer_name(std::size_t layer) {
  return layer == surface_layer ? "surface" : layer == background_layer ? "background" : fiber::lobe_names[layer];
}

/// Sums over paths; one path's are its values.
struct PathSums {
  std::array<glm::vec3, layer_count> layers{};  ///< radiance, linear RGB
  float coverage = 0;                           ///< paths that met a fiber or a surface; the next three are over these
  glm::vec3 albedo{0.0f};      ///< of one scattering: sum of the lobes' energies, or the surface's albedo
  glm::vec3 normal{0.0f};      ///< unit: tangent of a fiber, normal of a surface towards the camera
  float distance_cm = 0;       ///< from the camera
  std::uint32_t vertices = 0;  ///< hits that scattered
  std::uint32_t queries = 0, exact_queries = 0;
  float objective = 0;  ///< sum over the queries

  /// Sum of the layers, in their order.
  glm::vec3 beauty() const {
    glm::vec3 sum(0.0f);
    for (const glm::vec3& layer : layers) sum += layer;
    return sum;
  }

  PathSums& operator+=(const PathSums& other) {
    for (std::size_t layer = 0; layer < layer_count; ++layer) layers[layer] += other.layers[layer];
    coverage += other.coverage;
    albedo += other.albedo;
    normal += other.normal;
    distance_cm += other.distance_cm;
    vertices += other.vertices;
    queries += other.queries;
    exact_queries += other.exact_queries;
    objective += other.objective;
    return *this;
  }
};

}  // namespace tress::integrate
