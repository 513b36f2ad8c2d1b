// A knot table for one color: what a render would read of a row of knots.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "base/float4.h"
#include "models/elliptical/absorbed_row.h"
#include "references/learners/knot_density.h"

namespace tress::inline v0_2::fiber {

/// Straight lines between knots in three channels, each of mass 1, inverted under any mix of the channels. Immutable;
/// any thread. Its functions are those of AbsorbedRow.
class AbsorbedKnots {
 public:
  /// table: with knots.
  AbsorbedKnots(const adaptive::KnotDensity& table, const glm::vec3& sigma_a);

  RowValue evaluate(float x, const glm::vec3& channel_weights, float uniform_share) const;
  float sample(float u, const glm::vec3& channel_weights, float uniform_share) const;
  std::size_t bytes() const { return blocks_.size() * sizeof(Block); }

 private:
  static constexpr std::size_t block_size = 4;
  /// Four knots. Lanes 0 to 2 of each: the density of the channels, 1/rad. Lane 3 of knot c, c < 3: the mass of channel
  /// c between -pi and the first knot.
  struct alignas(64) Block {
    std::array<Float4, block_size> knot{splat(0), splat(0), splat(0), splat(0)};
  };
  /// All knots of a row, one after the other.
  const Float4* knots() const { return blocks_.front().knot.data(); }

  std::vector<Block> blocks_;
  std::uint32_t count_;  ///< number of knots
};

}  // namespace tress::inline v0_2::fiber
