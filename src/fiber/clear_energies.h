// The clear energies of a cross-section's lobes over (phi_r, cos theta), with what colors them: one for all colors.
#pragma once

#include <compare>
#include <map>
#include <memory>
#include <vector>

#include "fiber/path_rule.h"
#include "tress/fiber/lobes.h"
#include "tress/fiber/parameters.h"

namespace tress::fiber {

/// What clear energies depend on.
struct EnergyKey {
  float eta = 1.55f, eccentricity = 0.85f;
  float glint_sigma = 0;  ///< blur of TRT, radians, where it is split into GLINT and the rest; else 0
  friend auto operator<=>(const EnergyKey&, const EnergyKey&) = default;
};

EnergyKey energy_key(const FiberParameters& fiber);

/// On 64 x 64 nodes, phi_r uniform on [0, pi/2], cos theta uniform on [0, 1]. Every node is traced with 512 midpoint
/// rays; TT, TRT, TRRT and GLINT keep the Gauss rule of their path lengths l. The residual is everything after TRRT;
/// its rule is of e^(-l/20), in which long paths weigh little, over 64 rays followed until no more than 1e-3 of them is
/// left or 40 orders, each then going on at the rate at which it was losing light. Immutable after construction; any
/// thread.
class ClearEnergies {
 public:
  static constexpr int nodes_per_axis = 64;
  static constexpr int node_count = nodes_per_axis * nodes_per_axis;
  static constexpr int rays_per_node = 512;

  /// Traces in parallel in the calling oneTBB arena; the same bits on any number of threads.
  explicit ClearEnergies(const EnergyKey& key);

  const EnergyKey& key() const { return key_; }
  /// E_p of clear hair at a node, by lobe; sums to 1. The index is cosine * nodes_per_axis + azimuth.
  const std::array<float, lobe_count>& clear(int node) const { return clear_[static_cast<std::size_t>(node)]; }
  /// Weights and lengths of point k of a lobe other than R, by node (GLINT: where it is split off). The weights of the
  /// points sum to clear().
  const float* weights(Lobe lobe, int k) const { return rules_.data() + offset(lobe, k); }
  const float* lengths(Lobe lobe, int k) const { return rules_.data() + offset(lobe, k) + node_count; }

  std::size_t bytes() const;

 private:
  void trace(int node);
  void set(Lobe lobe, int node, const PathRule& rule);
  static std::size_t offset(Lobe lobe, int k) {
    return static_cast<std::size_t>(2 * ((static_cast<int>(lobe) - 1) * path_points + k)) * node_count;
  }

  EnergyKey key_;
  std::vector<std::array<float, lobe_count>> clear_;
  std::vector<float> rules_;  ///< [lobe - 1][point][weight, length][node]
};

/// One ClearEnergies per key, made when first asked for. One thread.
class SharedEnergies {
 public:
  std::shared_ptr<const ClearEnergies> find(const EnergyKey& key);

 private:
  std::map<EnergyKey, std::shared_ptr<const ClearEnergies>> made_;
};

}  // namespace tress::fiber
