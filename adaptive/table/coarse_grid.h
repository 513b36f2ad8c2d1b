// The coarse grid of a slice, whose nodes answer for their neighbours.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "tress/adaptive/target.h"

namespace tress::inline v0_2::adaptive {

/// The first of SliceDescription::coarse. Where a node has no row, the nodes of the grid around it answer. Immutable;
/// any thread.
class CoarseGrid {
 public:
  explicit CoarseGrid(const SliceDescription& slice);

  /// Whether the slice has none.
  bool empty() const { return a_.empty(); }
  bool has(std::uint32_t node) const {
    return !empty() && a_[node / width_].share == 0 && b_[node % width_].share == 0;
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
  /// The nodes of the grid around a node, with the weights of bilinear interpolation; their sum is 1. Of itself alone,
  /// if it is one of them. Precondition: !empty().
  Corners around(std::uint32_t node) const;

 private:
  /// Where a coordinate lies on an axis of a grid: at `share` of the way from index `below` to index `above`.
  struct Place {
    std::uint32_t below, above;
    float share;  ///< in [0, 1)
  };
  static std::vector<Place> places(const std::vector<float>& axis, const std::vector<std::uint32_t>& chosen);

  std::uint32_t width_;
  std::vector<Place> a_, b_;  ///< by index into the axes
};

}  // namespace tress::inline v0_2::adaptive
