// The results of a path: radiance by layer, properties of the first hit, queries of the table.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "base/bands.h"
#include "integrate/data_layers.h"
#include "scene/model/light.h"
#include "tress/fiber/lobes.h"

namespace tress::integrate {

/// Layers of a picture: one for each lobe of a fiber hit first, then surfaces hit first, lights that the camera sees
/// and the background.
constexpr std::size_t surface_layer = fiber::lobe_count, emission_layer = surface_layer + 1,
                      background_layer = emission_layer + 1, layer_count = background_layer + 1;
constexpr const char* layer_name(std::size_t layer) {
  return layer == surface_layer      ? "surface"
         : layer == emission_layer   ? "emission"
         : layer == background_layer ? "background"
                                     : fiber::lobe_names[layer];
}

/// Light by the group of the light that it comes from (scene::light_groups). It has `count` groups; with 0 it keeps
/// nothing.
struct GroupLight {
  std::array<glm::vec3, scene::most_light_groups> light{};  ///< linear RGB; only the first `count` are used
  std::size_t count = 0;

  explicit GroupLight(std::size_t groups = 0) : count(groups) {}
  void add(std::size_t group, const glm::vec3& radiance) {
    if (group < count) light[group] += radiance;
  }
};

/// The results of one path, as sums over its hits.
struct PathSums {
  std::array<glm::vec3, layer_count> layers{};  ///< radiance, linear RGB
  float coverage = 0;          ///< 1 if the path met a fiber or a surface; else 0, as are the next four members
  glm::vec3 albedo{0.0f};      ///< of one scattering: sum of the lobes' energies, or the surface's albedo
  glm::vec3 normal{0.0f};      ///< unit, towards the camera: across a fiber's axis, or the normal of a surface
  glm::vec3 tangent{0.0f};     ///< of a fiber, from root to tip, unit; 0 for a surface
  float distance_cm = 0;       ///< distance of the first hit from the camera
  std::uint32_t object = 0;    ///< object of the first hit: index of the groom, or of the mesh after all grooms
  glm::vec2 motion{0.0f};      ///< motion of the first hit or the backdrop until the next frame: pixels right and up
  DataHit data;                ///< values for the data layers that are requested
  std::uint32_t vertices = 0;  ///< hits that scattered
  std::uint32_t queries = 0, exact_queries = 0;
  float objective = 0;  ///< sum of the objectives of the queries
  /// Estimated excess of luminance, of either sign, by the rows of the path's vertices. It is traced at few vertices,
  /// which represent all (Scattering::excess).
  float excess = 0;
  /// Estimated excess of luminance, of either sign, by answers that replace paths (DeepLight::learned). It is measured
  /// on few of them, which represent all.
  float deep_light_excess = 0;
  std::uint32_t deep_light_checks = 0;  ///< number of answers that were compared with paths
  bool sees_light = false;              ///< whether the camera's ray ends at a light
  bool held_out = false;                ///< whether it ends at a matte, which shows nothing
  float light_cm = 0;                   ///< distance of that light from the camera, may be infinite; else 0
  GroupLight groups;                    ///< light of all layers except the background

  PathSums() = default;
  explicit PathSums(std::size_t group_count) : groups(group_count) {}

  /// Takes the bands (base/bands.h) of everything but the background to RGB. Estimates of excess remain luminances of
  /// bands.
  void take_rgb() {
    for (std::size_t layer = 0; layer < background_layer; ++layer) layers[layer] = rgb_of_bands(layers[layer]);
    for (std::size_t group = 0; group < groups.count; ++group) groups.light[group] = rgb_of_bands(groups.light[group]);
    albedo = rgb_of_bands(albedo);
  }

  /// Sum of the layers, in their order.
  glm::vec3 beauty() const {
    glm::vec3 sum(0.0f);
    for (const glm::vec3& layer : layers) sum += layer;
    return sum;
  }

  /// Whether all values are finite, including the sum of the layers, so that the film can take the path.
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
