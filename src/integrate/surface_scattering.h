// Scattering at surfaces of meshes: diffuse, with or without a coat (a rough dielectric).
#pragma once

#include <array>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace tress::integrate {

/// A rough dielectric over a surface. Its microfacets have the GGX distribution and Smith's height-correlated masking
/// (Walter et al. 2007; Heitz 2014). They reflect light once, by Fresnel's term. All other light, including light lost
/// between facets, reaches the diffuse surface. Immutable; thread-safe.
class Coat {
 public:
  /// roughness: in (0, 1]; its square is the width of the distribution. eta: > 1.
  Coat(float roughness, float eta);

  /// Share of the light from a direction of this cosine that the coat reflects, [0, 1]. It is interpolated linearly in
  /// the root of the cosine between 65 values, with an error of at most 0.002
  /// (tests/integrate/surface_scattering_test.cpp).
  float albedo(float cosine) const;
  /// Mean of albedo() over all directions: 2 times the integral of albedo(x) x over [0, 1].
  float mean_albedo() const { return mean_albedo_; }

  /// BRDF of the coat times the cosine of `in`; both unit, z along the normal, z > 0.
  float value(const glm::vec3& out, const glm::vec3& in) const;
  /// Draws a direction: `out` mirrored at a normal that is visible from `out` (Heitz 2018). It may lie below the
  /// surface.
  glm::vec3 sample(const glm::vec3& out, const glm::vec2& u) const;
  /// Density of sample() in solid angle.
  float pdf(const glm::vec3& out, const glm::vec3& in) const;

 private:
  static constexpr int cells = 64;

  float masking(const glm::vec3& direction) const;
  float distribution(const glm::vec3& normal) const;

  float width_, eta_, mean_albedo_ = 0;
  std::array<float, cells + 1> albedo_{};  ///< by the root of the cosine
};

/// Scattering at one point of a mesh, in its shading frame: z is the shading normal. It is reciprocal except for the
/// fade at the shading terminator, which the caller applies. It conserves energy, without loss if the diffuse albedo is
/// 1: (1 - E(out)) (1 - E(in)) / (1 - mean E) couples the diffuse part to the albedo E of the coat (Kelemen and
/// Szirmay-Kalos 2001).
struct SurfaceMaterial {
  glm::vec3 diffuse{0.0f};     ///< diffuse albedo, [0, 1]
  const Coat* coat = nullptr;  ///< null if there is no coat
  glm::vec3 out{0, 0, 1};      ///< unit, towards where the ray came from, z > 0
  float coat_albedo = 0;       ///< albedo of the coat for `out`

  SurfaceMaterial() = default;
  SurfaceMaterial(const glm::vec3& diffuse, const Coat* coat, const glm::vec3& out);

  /// Share of light that is scattered towards `out` under even light from all directions.
  glm::vec3 albedo() const;
  /// BRDF times the cosine of `in`, unit; 0 below the surface.
  glm::vec3 value(const glm::vec3& in) const;
  /// Draws a unit direction, which may lie below the surface. u: independent uniforms in [0, 1).
  glm::vec3 sample(const std::array<float, 4>& u) const;
  /// Density of sample() in solid angle. The diffuse part is drawn by the cosine.
  float pdf(const glm::vec3& in) const;

 private:
  float coat_share() const;  ///< share of the samples that the coat gets
};

}  // namespace tress::integrate
