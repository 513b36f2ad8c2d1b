// Converged rows as one fiber's color sees them: compact, immutable during a pass, read at every vertex.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "tress/adaptive/mixture.h"

namespace tress::fiber {

/// Value of a row at one azimuth: the shape of each channel (mass 1) and the density of the proposal. 1/rad.
struct RowValue {
  glm::vec3 shape{0.0f};
  float proposal = 0;
};

/// Share of the mass of a component that is left under absorption sigma_a: the gamma law of the moments of its path,
/// (1 + sigma_a v/l)^(-l^2/v), exp(-sigma_a l) for v -> 0. In [0, 1].
double absorbed_share(double sigma_a, double path_mean, double path_variance);

/// A circular skew logistic ready for evaluation: one exp, no division by Z.
struct TintedComponent {
  float mu, inverse_left, inverse_right;
  float inverse_norm;  ///< 1/Z
  glm::vec3 share;     ///< mass per channel, the whole row's being 1
  float reserved = 0;
};

/// One row under one color.
struct TintedRow {
  std::uint32_t first = 0;  ///< in the pool of components
  std::uint32_t count = 0;
  glm::vec3 uniform_share{1.0f};
};

/// The tinted rows of one page, by node. Thread-safety: reading: any; set/clear: one thread, no reader.
class TintedRows {
 public:
  explicit TintedRows(std::uint32_t node_count = 0) : slot_(node_count, none) {}

  void set(std::uint32_t node, const adaptive::Mixture& fit, const glm::vec3& sigma_a);
  void clear(std::uint32_t node) { slot_[node] = none; }
  bool has(std::uint32_t node) const { return slot_[node] != none; }

  /// channel_weights: mix of the channels that is sampled, >= 0, sum 1. The proposal is
  /// (1 - u) sum_c weight_c shape_c + u / 2 pi, so a weight in that mix is at most 1/(1 - u). x in [-pi, pi).
  RowValue evaluate(std::uint32_t node, float x, const glm::vec3& channel_weights, float uniform_share) const;
  /// Draws from that proposal. u in [0, 1), used up whole. Radians in [-pi, pi).
  float sample(std::uint32_t node, float u, const glm::vec3& channel_weights, float uniform_share) const;

 private:
  static constexpr std::uint32_t none = ~0u;
  std::vector<std::uint32_t> slot_;
  std::vector<TintedRow> rows_;
  std::vector<TintedComponent> components_;
};

}  // namespace tress::fiber
