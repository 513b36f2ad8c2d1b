// The coarse grid of a slice, whose nodes answer for their neighbours.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "tress/adaptive/target.h"

namespace tress::inline v0_2::adaptive {

/// The first of SliceDescription::coarse. Where a node has no row, the nodes of the grid around it answer. Immutable;
/// any thread.
class CoarseGrid {
 public:
  explicit CoarseGrid(const SliceDescription& slice) : width_(static_cast<std::uint32_t>(slice.axis_b.size())) {
    if (slice.coarse.empty()) return;
    a_ = places(slice.axis_a, slice.coarse.front().a);
    b_ = places(slice.axis_b, slice.coarse.front().b);
  }

  /// Whether the slice has none.
  bool empty() const { return a_.empty(); }
  bool has(std::uint32_t node) const {
    return !empty() && a_[node / width_].share == 0 && b_[node % width_].share == 0;
  }

  struct Corner {
    std::uint32_t node;
    float weight;  ///< of bilinear interpolation, >= 0
  };
  /// The nodes of the grid around a node, some more than once with weight 0; the weights add up to 1. Precondition:
  /// !empty().
  std::array<Corner, 4> around(std::uint32_t node) const {
    const Place &a = a_[node / width_], &b = b_[node % width_];
    return {{{a.below * width_ + b.below, (1 - a.share) * (1 - b.share)},
             {a.below * width_ + b.above, (1 - a.share) * b.share},
             {a.above * width_ + b.below, a.share * (1 - b.share)},
             {a.above * width_ + b.above, a.share * b.share}}};
  }

 private:
  /// Where a coordinate lies on an axis of the grid: at `share` of the way from index `below` to index `above`.
  struct Place {
    std::uint32_t below, above;
    float share;  ///< in [0, 1); 0 if the index is one of the grid, and then `below` and `above` are it
  };
  static std::vector<Place> places(const std::vector<float>& axis, const std::vector<std::uint32_t>& chosen) {
    std::vector<Place> places;
    for (std::uint32_t i = 0; i < axis.size(); ++i) {
      const auto above = std::ranges::lower_bound(chosen, i);  // the first index and the last are chosen
      const std::uint32_t below = *above == i ? i : *(above - 1);
      places.push_back({below, *above, *above == i ? 0 : (axis[i] - axis[below]) / (axis[*above] - axis[below])});
    }
    return places;
  }

  std::uint32_t width_;
  std::vector<Place> a_, b_;  ///< by index into the axes
};

}  // namespace tress::inline v0_2::adaptive
