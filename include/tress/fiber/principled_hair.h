// Converts the hair of Blender's Principled Hair node, and of other models after Chiang et al. 2016, into a fiber.
#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <optional>

#include "tress/fiber/parameters.h"

namespace tress::inline v0_2::fiber {

/// The widths of the lobes of a round fiber.
enum class PrincipledWidths {
  by_model,   ///< `published` with the model `chiang2016`, whose lobes they are; `fitted` with every other model
  fitted,     ///< those by which the lobes of `elliptical` look like the published model (scenes/blender/README.md)
  published,  ///< those of Chiang et al. 2016
  /// Those of equal half width and of equal blur, with the energies of a smooth fiber: dense hair of `elliptical` is
  /// nearest to the published model by these (include/hosts.md).
  equal,
};

/// The settings of an artist; defaults are the node's. Absorption is per radius of the fiber.
struct PrincipledHair {
  float roughness = 0.3f;         ///< longitudinal beta_M, [0, 1]; for elliptical fibers, that of the surface
  float radial_roughness = 0.3f;  ///< azimuthal beta_N, [0, 1]; unused for elliptical fibers
  float coat = 0;                 ///< share, [0, 1], of its roughness that R lacks; unused for elliptical fibers
  float eta = 1.55f;              ///< index of refraction, [1.05, 3]
  /// Tilt of the cuticle scales, radians; R is turned towards the root. pbrt's alpha turns it towards the tip.
  float offset = 0.0349066f;
  glm::vec3 sigma_a{0.0f};  ///< absorption, >= 0, linear RGB
  /// Minor over major semi-axis: elliptical fibers with one roughness (Huang et al. 2022). If unset: Chiang's round
  /// fibers.
  std::optional<float> aspect_ratio = {};
  PrincipledWidths widths = PrincipledWidths::by_model;  ///< unused for elliptical fibers
};

/// The fiber that scatters like the node. Round fibers get lobes of Chiang's variances and logistic scales and an
/// almost smooth surface, of roughness 0.02, or 0.001 with `equal` widths. Without a tilt of the cuticle, the energies
/// are the node's, but for oblique light at 0.02 (0.813 instead of 0.889 at 75 degrees in one case). With a tilt, the
/// traced scales lose less or more at grazing inclinations than lobes that are merely turned (in one case 0.60 instead
/// of 0.68). Widths, tilt and aspect ratio are clamped to their ranges (parameter_ranges.h).
FiberParameters fiber_of(const PrincipledHair& hair);

/// The inputs of MaterialX's chiang_hair_bsdf and their defaults. Its lobes are R, TT, TRT; later ones are as TRT.
struct ChiangHair {
  std::array<glm::vec3, 3> tint{glm::vec3(1.0f), glm::vec3(1.0f), glm::vec3(1.0f)};  ///< factor of the lobe, [0, 1]
  float eta = 1.55f;                                              ///< its `ior`: index of refraction, [1.05, 3]
  std::array<float, 3> longitudinal_variance{0.1f, 0.05f, 0.2f};  ///< variance of theta_i, radians squared, > 0
  std::array<float, 3> azimuthal_scale{0.1f, 0.05f, 0.2f};  ///< logistic, before the factor sqrt(pi/8), radians, > 0
  float cuticle_angle = 0.5f;                               ///< [0, 1]: the scales are tilted by pi (c - 1/2)
  glm::vec3 sigma_a{0.0f};                                  ///< its `absorption_coefficient`, per radius, linear RGB
};

/// The fiber that scatters like the node, by PrincipledWidths::by_model.
FiberParameters fiber_of(const ChiangHair& hair);

/// Absorption of hair of that multiple scattering albedo (Chiang et al. 2016), as the node computes it for colors and
/// tints. color: linear RGB, clamped to [1e-5, 1]. radial_roughness: beta_N; for elliptical fibers, their roughness;
/// [0, 1], clamped. NaN counts as the least, here and below.
glm::vec3 sigma_a_of_principled_color(const glm::vec3& color, float radial_roughness);

/// Absorption of melanin in [0, 1], of which the share `redness` in [0, 1] is pheomelanin; clamped.
glm::vec3 sigma_a_of_principled_melanin(float melanin, float redness);

}  // namespace tress::inline v0_2::fiber
