// A converged row for one color: an immutable, packed block of memory that is read at every vertex.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>

#include "tress/adaptive/mixture.h"

namespace tress::inline v0_2::fiber {

/// The value of a row at one azimuth: the shape of each channel (mass 1) and the density of the proposal. 1/rad.
struct RowValue {
  glm::vec3 shape{0.0f};
  float proposal = 0;
};

/// Two circular skew logistics and the common data of a row, in one cache line. A row consists of its first line
/// and one line for each further pair of components, whose uniform part is 0. Components that a row does not have get
/// amplitude 0. Densities are in 1/rad; the row's mass is 1 in each channel.
struct alignas(64) AbsorbedRow {
  std::array<float, 2> mu{}, inverse_left{1, 1}, inverse_right{1, 1};
  glm::vec3 amplitude[2]{glm::vec3(0.0f), glm::vec3(0.0f)};  ///< mass by channel over Z: the factor on E/(1 + E)^2
  glm::vec3 uniform{0.0f};                                   ///< density of the uniform part by channel

  std::uint32_t tail = 0;                            ///< objective, with these flags in its lowest byte:
  static constexpr std::uint32_t has_no_row = 0x80;  ///< the node is uniform and has no row in the service
  static constexpr std::uint32_t size_bits = 0x7f;   ///< number of further lines

  bool has_row() const { return (tail & has_no_row) == 0; }
  /// The value of adaptive::RowView::objective, to 2^-15 of it.
  float objective() const { return std::bit_cast<float>(tail & ~0xffu); }
  std::uint32_t lines_behind() const { return tail & size_bits; }

  /// channel_weights: the mix of the channels that is sampled, >= 0, sum 1. The proposal is (1 - u) sum_c weight_c
  /// shape_c + u / 2 pi, u the uniform share, so a weight in that mix is at most 1/(1 - u). x in [-pi, pi).
  RowValue evaluate(float x, const glm::vec3& channel_weights, float uniform_share) const;
  /// Draws from that proposal. u in [0, 1); all its bits are used. Radians in [-pi, pi).
  float sample(float u, const glm::vec3& channel_weights, float uniform_share) const;
};
static_assert(sizeof(AbsorbedRow) == 64);

/// A row of density 0, which is not in the service.
inline constexpr AbsorbedRow zero_density_row{.tail = AbsorbedRow::has_no_row};

/// A row's fit under one absorption, as lines of 64 bytes: the first function returns the number of bytes, the second
/// puts the row into as many, which are aligned to 64 and never destroyed. Pure.
std::size_t absorbed_bytes(const adaptive::Mixture& fit);
const AbsorbedRow* put_absorbed(const adaptive::Mixture& fit, float objective, const glm::vec3& sigma_a, void* memory);

}  // namespace tress::inline v0_2::fiber
