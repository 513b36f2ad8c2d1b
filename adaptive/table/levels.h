// The coarse grids of a slice, whose nodes answer for their neighbours.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tress/adaptive/target.h"

namespace tress::inline v0_2::adaptive {

/// The grids of a slice of samples, from the coarsest (level 0) to the slice's own (level coarse()). Where a node has
/// no row at its level, the nodes of the level above around it answer for it. Immutable; any thread.
class Levels {
 public:
  explicit Levels(const SliceDescription& slice);

  /// Number of grids above the slice's own.
  std::size_t coarse() const { return grids_.size() - 1; }
  /// Whether the node belongs to the grid of a level.
  bool has(std::size_t level, std::uint32_t node) const {
    return grids_[level].a[node / width_].share == 0 && grids_[level].b[node % width_].share == 0;
  }

  struct Corner {
    std::uint32_t node;
    float weight;  ///< > 0
  };
  struct Corners {
    std::array<Corner, 4> all;
    std::uint32_t count = 0;
    const Corner* begin() const { return all.data(); }
    const Corner* end() const { return all.data() + count; }
  };
  /// The nodes of a level around a node, with the weights of bilinear interpolation; their sum is 1.
  Corners around(std::size_t level, std::uint32_t node) const;

 private:
  /// Where a coordinate lies on an axis of a grid: at `share` of the way from index `below` to index `above`.
  struct Place {
    std::uint32_t below, above;
    float share;  ///< in [0, 1)
  };
  struct Grid {
    std::vector<Place> a, b;
  };
  static std::vector<Place> places(const std::vector<float>& axis, const std::vector<std::uint32_t>& chosen);

  std::uint32_t width_;
  std::vector<Grid> grids_;
};

}  // namespace tress::inline v0_2::adaptive
