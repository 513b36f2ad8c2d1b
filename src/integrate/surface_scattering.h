// How surfaces of meshes scatter: diffuse, with or without a coat that mirrors (a rough dielectric).
#pragma once

#include <array>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace tress::integrate {

/// A rough dielectric over a surface, by its directional albedo. Microfacets have the GGX distribution and Smith's
/// height-correlated masking (Walter et al. 2007; Heitz 2014); reflected once, times Fresnel's term. What does not come
/// back from it, or is lost between facets, reaches the diffuse surface. Immutable; any thread.
class Coat {
 public:
  /// roughness: (0, 1], its square is the width of the distribution. eta: > 1.
  Coat(float roughness, float eta);

  /// Share of the light from a direction of this cosine that leaves by the coat, [0, 1]: linear in the root of
  /// the cosine between 65 of them, good to 0.002 (tests/integrate/surface_scattering_test.cpp).
  float albedo(float cosine) const;
  /// The mean of it over all directions: 2 times the integral of albedo(x) x over [0, 1].
  float mean_albedo() const { return mean_albedo_; }

  /// BRDF of the coat times the cosine of `in`; both unit, z along the normal, z > 0.
  float value(const glm::vec3& out, const glm::vec3& in) const;
  /// A direction by the normals that are seen from `out` (Heitz 2018), mirrored: it may lie below the surface.
  glm::vec3 sample(const glm::vec3& out, const glm::vec2& u) const;
  /// Its density in solid angle.
  float pdf(const glm::vec3& out, const glm::vec3& in) const;

 private:
  static constexpr int cells = 64;

  float masking(const glm::vec3& direction) const;
  float distribution(const glm::vec3& normal) const;

  float width_, eta_, mean_albedo_ = 0;
  std::array<float, cells + 1> albedo_{};  ///< by the root of the cosine
};

/// What scatters at one point of a mesh, in its shading frame: z is the shading normal. Reciprocal but for the fade of
/// the shading terminator, which its caller multiplies with. Sent back is at most what arrives, and all of it where the
/// diffuse albedo is 1: (1 - E(out)) (1 - E(in)) / (1 - mean E) couples the diffuse part to the albedo E of the coat
/// (Kelemen and Szirmay-Kalos 2001).
struct SurfaceMaterial {
  glm::vec3 diffuse{0.0f};     ///< albedo, [0, 1]
  const Coat* coat = nullptr;  ///< null: none
  glm::vec3 out{0, 0, 1};      ///< unit, towards where the ray came from, z > 0
  float coat_albedo = 0;       ///< of `out`

  SurfaceMaterial() = default;
  SurfaceMaterial(const glm::vec3& diffuse, const Coat* coat, const glm::vec3& out);

  /// Of light sent back towards `out` when as much comes from everywhere.
  glm::vec3 albedo() const;
  /// BRDF times the cosine of `in`, unit; 0 below the surface.
  glm::vec3 value(const glm::vec3& in) const;
  /// u: independent uniforms in [0, 1). Unit; may lie below the surface.
  glm::vec3 sample(const std::array<float, 4>& u) const;
  /// Density in solid angle of drawing it. The diffuse part is drawn by the cosine.
  float pdf(const glm::vec3& in) const;

 private:
  float coat_share() const;  ///< of the samples
};

}  // namespace tress::integrate
