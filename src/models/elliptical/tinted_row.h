// A converged row as one color sees it: one packed block of memory, immutable, read at every vertex.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <mutex>
#include <vector>

#include "fiber/float4.h"
#include "tress/adaptive/knot_table.h"
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

/// Four circular skew logistics ready for evaluation, in lanes: one exp, no division by Z. Lanes beyond a row's count
/// have no amplitude.
struct TintedParts {
  Float4 mu = splat(0), inverse_left = splat(1), inverse_right = splat(1);
  Float4 norm = splat(1);                                         ///< Z
  std::array<Float4, 3> amplitude{splat(0), splat(0), splat(0)};  ///< mass by channel over Z; the whole row's mass is 1
};

/// Four knots of a table, 64 bytes. Lanes 0 to 2 of each: the density of the channels, 1/rad, each channel of mass 1.
/// Lane 3 of knot c, c < 3: the mass of channel c between -pi and the first knot.
struct TintedKnots {
  std::array<Float4, 4> knot{splat(0), splat(0), splat(0), splat(0)};
};

/// The head of a block; what a row is made of follows in memory, four to a part: components, or knots.
struct alignas(16) TintedRow {
  std::uint32_t count = 0;        ///< of components; 0 where the row is a knot table
  std::uint32_t knot_count = 0;   ///< a power of two; 0 where the row is a mixture
  float objective = 0;            ///< adaptive::RowView::objective
  bool has_row = true;            ///< false: the node is uniform, no row of the service's stands behind it
  glm::vec3 uniform_share{1.0f};  ///< of a mixture, per channel; 1 where no light is left and the shape does not matter

  const TintedParts* parts() const { return reinterpret_cast<const TintedParts*>(this + 1); }
  TintedParts* parts() { return reinterpret_cast<TintedParts*>(this + 1); }
  const TintedKnots* knots() const { return reinterpret_cast<const TintedKnots*>(this + 1); }
  TintedKnots* knots() { return reinterpret_cast<TintedKnots*>(this + 1); }

  /// channel_weights: mix of the channels that is sampled, >= 0, sum 1. The proposal is
  /// (1 - u) sum_c weight_c shape_c + u / 2 pi, so a weight in that mix is at most 1/(1 - u). x in [-pi, pi).
  RowValue evaluate(float x, const glm::vec3& channel_weights, float uniform_share) const;
  /// Draws from that proposal. u in [0, 1), used up whole. Radians in [-pi, pi).
  float sample(float u, const glm::vec3& channel_weights, float uniform_share) const;

 private:
  // tinted_knots.cpp: the same of a knot table.
  RowValue evaluate_knots(float x, const glm::vec3& channel_weights, float uniform_share) const;
  float sample_knots(float u, const glm::vec3& channel_weights, float uniform_share) const;
};
static_assert(sizeof(TintedRow) == 32 && sizeof(TintedParts) == 112 && sizeof(TintedKnots) == 64);

/// Owns blocks until it is destroyed. Any thread.
class TintedRowPool {
 public:
  /// A row's fit under one absorption.
  const TintedRow* make(const adaptive::Mixture& fit, float objective, const glm::vec3& sigma_a);
  const TintedRow* make(const adaptive::KnotTable& table, float objective, const glm::vec3& sigma_a);
  std::size_t bytes() const;

 private:
  /// A row with this much memory behind it, a multiple of 16 bytes.
  TintedRow* allocate(std::size_t bytes_behind);
  struct alignas(16) Line {
    std::byte bytes[16];
  };
  static constexpr std::size_t chunk_lines = 2048;
  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<Line[]>> chunks_;
  std::size_t used_lines_ = chunk_lines;  ///< of the last chunk
};

}  // namespace tress::fiber
