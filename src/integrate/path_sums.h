// What a path brings: radiance by layer, what the first hit is like, queries of the table.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "integrate/data_layers.h"
#include "scene/model/light.h"
#include "tress/fiber/lobes.h"

namespace tress::integrate {

/// Layers of a picture: the lobe of the first fiber hit, then surfaces first hit, lights that the camera sees, then
/// what is behind everything.
constexpr std::size_t surface_layer = fiber::lobe_count, emission_layer = surface_layer + 1,
                      background_layer = emission_layer + 1, layer_count = background_layer + 1;
constexpr const char* layer_name(std::size_t layer) {
  return layer == surface_layer      ? "surface"
         : layer == emission_layer   ? "emission"
         : layer == background_layer ? "background"
                                     : fiber::lobe_names[layer];
}

/// Light by the group of the light that it comes from (scene::light_groups). Of `count` groups; 0: nothing is kept.
struct GroupLight {
  std::array<glm::vec3, scene::most_light_groups> light{};  ///< linear RGB; the first `count`
  std::size_t count = 0;

  explicit GroupLight(std::size_t groups = 0) : count(groups) {}
  void add(std::size_t group, const glm::vec3& radiance) {
    if (group < count) light[group] += radiance;
  }
};

/// What one path brings: sums over its hits.
struct PathSums {
  std::array<glm::vec3, layer_count> layers{};  ///< radiance, linear RGB
  float coverage = 0;                           ///< 1: met a fiber or a surface; else this and the next four are 0
  glm::vec3 albedo{0.0f};      ///< of one scattering: sum of the lobes' energies, or the surface's albedo
  glm::vec3 normal{0.0f};      ///< unit, towards the camera: across the axis of a fiber, or of a surface
  glm::vec3 tangent{0.0f};     ///< unit, of a fiber, root to tip; 0 of a surface
  float distance_cm = 0;       ///< from the camera
  std::uint32_t object = 0;    ///< what was met: index of the groom, or of the mesh after all grooms
  glm::vec2 motion{0.0f};      ///< pixels right and up until the next frame, of what is seen or of the backdrop
  DataHit data;                ///< of layers that are asked for
  std::uint32_t vertices = 0;  ///< hits that scattered
  std::uint32_t queries = 0, exact_queries = 0;
  float objective = 0;  ///< sum over the queries
  /// Luminance that the rows of the path's vertices bring too much, of either sign: traced at few vertices, which
  /// stand for all (Scattered::excess).
  float excess = 0;
  /// Luminance that answers in place of paths bring too much, of either sign (DeepLight::learned): of few of them,
  /// which stand for all.
  float deep_light_excess = 0;
  std::uint32_t deep_light_checks = 0;  ///< answers that were held against what paths find
  bool sees_light = false;              ///< the camera's ray ends at a light
  bool held_out = false;                ///< or at a matte, which shows nothing
  GroupLight groups;                    ///< of all layers but the background

  PathSums() = default;
  explicit PathSums(std::size_t group_count) : groups(group_count) {}

  /// Sum of the layers, in their order.
  glm::vec3 beauty() const {
    glm::vec3 sum(0.0f);
    for (const glm::vec3& layer : layers) sum += layer;
    return sum;
  }

  /// Whether all of it can go to the film: no channel is NaN or infinite, nor is the sum of the layers.
  bool is_finite() const {
    const glm::vec3 light = beauty();  // finite only if every layer is
    for (int c = 0; c < 3; ++c) {
      if (!std::isfinite(light[c]) || !std::isfinite(albedo[c]) || !std::isfinite(normal[c])) return false;
      if (!std::isfinite(tangent[c])) return false;
    }
    const glm::vec3& place = data.position;
    if (!std::isfinite(place.x) || !std::isfinite(place.y) || !std::isfinite(place.z)) return false;
    return std::isfinite(motion.x) && std::isfinite(motion.y) && std::isfinite(coverage) &&
           std::isfinite(distance_cm) && std::isfinite(objective) && std::isfinite(excess) &&
           std::isfinite(deep_light_excess);
  }
};

}  // namespace tress::integrate
