#include "table/coarse_grid.h"

#include <algorithm>

namespace tress::inline v0_2::adaptive {

std::vector<CoarseGrid::Place> CoarseGrid::places(const std::vector<float>& axis,
                                                  const std::vector<std::uint32_t>& chosen) {
  std::vector<Place> places;
  places.reserve(axis.size());
  for (std::uint32_t i = 0; i < axis.size(); ++i) {
    const auto above = std::ranges::lower_bound(chosen, i);
    if (*above == i) {  // the first index and the last are chosen
      places.push_back({i, i, 0});
    } else {
      const std::uint32_t below = *(above - 1);
      places.push_back({below, *above, (axis[i] - axis[below]) / (axis[*above] - axis[below])});
    }
  }
  return places;
}

CoarseGrid::CoarseGrid(const SliceDescription& slice) : width_(static_cast<std::uint32_t>(slice.axis_b.size())) {
  if (slice.coarse.empty()) return;
  a_ = places(slice.axis_a, slice.coarse.front().a);
  b_ = places(slice.axis_b, slice.coarse.front().b);
}

CoarseGrid::Corners CoarseGrid::around(std::uint32_t node) const {
  const Place &a = a_[node / width_], &b = b_[node % width_];
  Corners corners;
  const auto add = [&](std::uint32_t at_a, std::uint32_t at_b, float weight) {
    if (weight > 0) corners.all[corners.count++] = {at_a * width_ + at_b, weight};
  };
  add(a.below, b.below, (1 - a.share) * (1 - b.share));
  add(a.below, b.above, (1 - a.share) * b.share);
  add(a.above, b.below, a.share * (1 - b.share));
  add(a.above, b.above, a.share * b.share);
  return corners;
}

}  // namespace tress::inline v0_2::adaptive
