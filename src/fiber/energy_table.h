// The energies of a fiber's lobes over (phi_r, theta_r), under its color and gains: shared by all estimators.
#pragma once

#include <array>
#include <cstddef>
#include <glm/vec3.hpp>
#include <memory>
#include <vector>

#include "fiber/clear_energies.h"
#include "tress/fiber/lobes.h"
#include "tress/fiber/parameters.h"

namespace tress::fiber {

/// Energies of the lobes at one known direction.
struct LobeEnergies {
  LobeColors colored{};                   ///< E_p per channel under sigma_a, times the gain
  std::array<float, lobe_count> clear{};  ///< E_p of clear hair, exact Fresnel, without gain; sums to 1
  float smooth_reflection = 0;  ///< E_R of a smooth surface, exact Fresnel: what R's closed form integrates to
};

/// E_p(phi_r, theta_r), bilinear between the nodes of ClearEnergies, which are colored by their rules. Immutable after
/// construction; any thread.
class EnergyTable {
 public:
  /// `clear` is of energy_key(fiber); many fibers share it. Takes sigma_a, gain and reflection_fresnel of the
  /// fiber; E_R is of that kind of Fresnel, times the same share of the smooth one's.
  EnergyTable(std::shared_ptr<const ClearEnergies> clear, const FiberParameters& fiber);

  /// phi_r absolute, any turn; theta within +-pi/2. A lobe other than R whose energy here is below 1e-3, clear or as
  /// its share of the colored luminance, is 0 and its energy is the residual's: sums are kept.
  LobeEnergies at(float phi_r, float theta) const;
  /// The same without that step.
  LobeEnergies interpolated(float phi_r, float theta) const;

  /// Of one channel under any sigma_a, with exact Fresnel and without gain: slow, for what is made once.
  std::array<double, lobe_count> without_gain(float phi_r, float theta, float sigma_a) const;

  const ClearEnergies& clear() const { return *clear_; }
  /// Without the shared part.
  std::size_t bytes() const { return sizeof(*this) + colored_.capacity() * sizeof(LobeColors); }

 private:
  std::shared_ptr<const ClearEnergies> clear_;
  std::vector<LobeColors> colored_;  ///< by node
};

}  // namespace tress::fiber
