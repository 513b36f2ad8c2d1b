// The energies of a fiber's lobes over (phi_r, theta_r), with its color and gains. All estimators share them.
#pragma once

#include <array>
#include <cstddef>
#include <glm/vec3.hpp>
#include <memory>
#include <vector>

#include "fiber/clear_energies.h"
#include "tress/fiber/lobes.h"
#include "tress/fiber/parameters.h"

namespace tress::inline v0_2::fiber {

/// Energies of the lobes at one known direction.
struct LobeEnergies {
  LobeColors colored{};                   ///< E_p per channel under sigma_a, with the gain
  std::array<float, lobe_count> clear{};  ///< E_p of clear hair, exact Fresnel, without gain; sums to 1
  float smooth_reflection = 0;  ///< E_R of a smooth surface with exact Fresnel: the integral of R's closed form
};

/// E_p(phi_r, theta_r), bilinear between the nodes of ClearEnergies, which are colored by their Gauss rules. Immutable
/// after construction; any thread.
class EnergyTable {
 public:
  /// `clear` must be of energy_key(fiber); many fibers share it. Reads sigma_a, gain and reflection_fresnel of the
  /// fiber. E_R is that of a smooth surface with this kind of Fresnel, times the ratio of rough to smooth E_R under
  /// exact Fresnel.
  EnergyTable(std::shared_ptr<const ClearEnergies> clear, const FiberParameters& fiber);

  /// phi_r absolute, any turn; theta within +-pi/2. If the energy of a lobe other than R is below 1e-3 here, clear or
  /// as its share of the colored luminance, it is set to 0 and added to the residual, which keeps the sums.
  LobeEnergies at(float phi_r, float theta) const;
  /// The same without this step.
  LobeEnergies interpolated(float phi_r, float theta) const;

  /// Energies of one channel under any sigma_a, with exact Fresnel and without gain. It is slow; do not call it at
  /// every vertex.
  std::array<double, lobe_count> without_gain(float phi_r, float theta, float sigma_a) const;

  const ClearEnergies& clear() const { return *clear_; }
  /// The memory without the shared part.
  std::size_t bytes() const { return sizeof(*this) + colored_.capacity() * sizeof(LobeColors); }

 private:
  std::shared_ptr<const ClearEnergies> clear_;
  std::vector<LobeColors> colored_;  ///< by node
};

}  // namespace tress::inline v0_2::fiber
