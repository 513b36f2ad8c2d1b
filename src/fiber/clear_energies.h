// The clear energies of a rough fiber's lobes over (phi_r, theta_r), with the path lengths from which they are colored.
// All colors share them.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <memory>
#include <vector>

#include "fiber/path_rule.h"
#include "fiber/traced_energies.h"
#include "tress/fiber/lobes.h"

namespace tress::inline v0_2::fiber {

/// The energies on 24 x 65 nodes, phi_r uniform on [0, pi/2], theta_r uniform on [-pi/2, pi/2]. Every node has the
/// moments of TracedEnergies; lobes other than R keep the Gauss rule of y = e^(-decay l) over their path lengths l. The
/// residual is everything after TRRT: what the others leave of 1, minus what a medulla absorbs. Standard error of an
/// energy: 0.006 of all light (median over lobes and fibers; the error of its mean over directions is 0.001). Immutable
/// after construction; any thread.
class ClearEnergies {
 public:
  static constexpr int azimuths = 24, inclinations = 65, node_count = azimuths * inclinations;

  /// Traces in parallel in the calling oneTBB arena. The bits are the same for any number of threads.
  explicit ClearEnergies(const EnergyKey& key);

  const EnergyKey& key() const { return key_; }

  /// E_p of clear hair by lobe; they sum to 1 without an absorbing medulla. The last entry is the light that enters a
  /// smooth surface, over 1 - F at azimuthally normal incidence. That is nearly constant, so the smooth E_R is
  /// interpolated to 1e-4.
  static constexpr std::size_t let_in = lobe_count;
  using Node = std::array<float, lobe_count + 2>;
  /// The index of a node is inclination * azimuths + azimuth.
  const Node& clear(int node) const { return clear_[static_cast<std::size_t>(node)]; }
  static float phi_of(int node);
  static float theta_of(int node);
  /// Weights and lengths of point k of a lobe other than R, by node (GLINT: if it is split off). The weights of the
  /// points sum to clear().
  const float* weights(Lobe lobe, int k) const { return rules_.data() + offset(lobe, k); }
  const float* lengths(Lobe lobe, int k) const { return rules_.data() + offset(lobe, k) + node_count; }

  std::size_t bytes() const;

 private:
  void set(int node, const LobeMoments& moments);
  void set(Lobe lobe, int node, const PathRule& rule);
  static std::size_t offset(Lobe lobe, int k) {
    return static_cast<std::size_t>(2 * ((static_cast<int>(lobe) - 1) * path_points + k)) * node_count;
  }

  EnergyKey key_;
  std::vector<Node> clear_;
  std::vector<float> rules_;  ///< [lobe - 1][point][weight, length][node]
};

/// One ClearEnergies for each key, made on first use, with the same bits whatever was made before. One thread.
class SharedEnergies {
 public:
  std::shared_ptr<const ClearEnergies> find(const EnergyKey& key);

 private:
  std::map<EnergyKey, std::shared_ptr<const ClearEnergies>> made_;
};

}  // namespace tress::inline v0_2::fiber
