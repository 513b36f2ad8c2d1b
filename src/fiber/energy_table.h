// The energies of a fiber's lobes over (phi_r, cos theta): shared by all estimators, made once per fiber.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "tress/fiber/lobes.h"

namespace tress::fiber {

/// Energies of the lobes at one known direction.
struct LobeEnergies {
  LobeColors colored{};                   ///< E_p per channel under sigma_a
  std::array<float, lobe_count> clear{};  ///< E_p of clear hair; sums to 1
};

/// Relative luminance of linear RGB (Rec. 709).
float luminance(const glm::vec3& color);

/// E_p(phi_r, theta) on 64 x 64 nodes, phi_r uniform on [0, pi/2] and cos theta uniform on [0, 1], bilinear between.
/// Every node is traced with 512 midpoint rays under this very sigma_a; the residual is everything after TRRT, its
/// color from 64 rays, each exit with its own path length, up to 300 orders or 1e-7 of a ray. Immutable after
/// construction; any thread.
class EnergyTable {
 public:
  /// sigma_a per major semi-axis, >= 0. Traces in parallel in the calling oneTBB arena; the same bits on any number
  /// of threads.
  EnergyTable(float eta, float eccentricity, const glm::vec3& sigma_a);

  /// phi_r absolute, any turn; theta of either sign. A lobe TT, TRT or TRRT whose energy here is below 1e-3, clear or
  /// as its share of the colored luminance, is 0 and its energy is the residual's: sums are kept.
  LobeEnergies at(float phi_r, float theta) const;
  /// The same without that step.
  LobeEnergies interpolated(float phi_r, float theta) const;

  std::size_t bytes() const { return sizeof(*this) + nodes_.capacity() * sizeof(LobeEnergies); }

  static constexpr int nodes_per_axis = 64;
  static constexpr int rays_per_node = 512;

 private:
  std::vector<LobeEnergies> nodes_;  ///< [cosine][phi]
};

/// What a node of the table holds, at any direction and number of midpoint rays (a multiple of 16). phi_r, theta in
/// radians.
LobeEnergies traced_energies(float eta, float eccentricity, const glm::vec3& sigma_a, double phi_r, double theta,
                             int rays);

}  // namespace tress::fiber
