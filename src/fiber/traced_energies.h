// The light that leaves a rough fiber, by lobe, traced for known directions and expressed as a series in them.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "fiber/traced_parts.h"
#include "tress/fiber/lobes.h"
#include "tress/fiber/parameters.h"

namespace tress::inline v0_2::fiber {

/// The parameters on which clear energies depend. Angles in radians.
struct EnergyKey {
  float eta = 1.55f, eccentricity = 0.85f;
  float roughness = 0.2f, tilt = 0;
  float glint_sigma = 0;  ///< blur of TRT if it is split into GLINT and the rest; else 0
  int paths = 320;        ///< per node; a round fiber has 12 times fewer nodes, 4 times the paths
  TracedParts parts{};
  friend auto operator<=>(const EnergyKey&, const EnergyKey&) = default;
};

/// Uses the material's roughness, even if lobe widths are given too.
EnergyKey energy_key(const FiberParameters& fiber);

/// Moments 0 to 5 of y = e^(-decay l) over the clear light of a lobe other than R, l the path length inside in major
/// semi-axes. Unlike moments of l they are bounded: some light of a rough fiber runs along it.
using LengthMoments = std::array<double, 6>;
double length_decay(Lobe lobe);

/// Light for unit flux by lobe, with sigma_a 0. The residual is what leaves after TRRT.
struct LobeMoments {
  double reflected = 0;
  std::array<LengthMoments, lobe_count> later{};  ///< by lobe; R's unused
};

/// Traces paths through the rough, tilted fiber (RoughPaths) at the nodes of a cosine series in phi_r and a Chebyshev
/// series in theta_r, which then gives the moments anywhere. This filters out noise between nodes and detail finer than
/// the roughness leaves. Traces in parallel in the calling oneTBB arena, with the same bits for any number of threads.
/// Immutable after construction; any thread.
class TracedEnergies {
 public:
  static constexpr std::size_t most_azimuths = 12, inclinations = 24;

  explicit TracedEnergies(const EnergyKey& key);

  /// The moments at all phi of one axis and theta of the other, [theta][phi]. phi in [0, pi/2], theta within +-pi/2,
  /// radians. A series may be negative where there is little light.
  std::vector<LobeMoments> at(const std::vector<double>& phi, const std::vector<double>& theta) const;

 private:
  static constexpr std::size_t fields = sizeof(LobeMoments) / sizeof(double);
  using Fields = std::array<double, fields>;
  Fields traced(const EnergyKey& key, std::size_t node) const;

  std::size_t azimuths_;       ///< 1 for a round fiber, where phi_r makes no difference
  int paths_;                  ///< per node
  std::vector<Fields> nodes_;  ///< [theta][phi]
};

}  // namespace tress::inline v0_2::fiber
