#include "table/levels.h"

#include <algorithm>
#include <numeric>

namespace tress::inline v0_2::adaptive {

std::vector<Levels::Place> Levels::places(const std::vector<float>& axis, const std::vector<std::uint32_t>& chosen) {
  std::vector<Place> places;
  places.reserve(axis.size());
  for (std::uint32_t i = 0; i < axis.size(); ++i) {
    const auto above = std::ranges::lower_bound(chosen, i);
    if (above == chosen.end()) {  // i is past the last chosen index
      places.push_back({chosen.back(), chosen.back(), 0});
    } else if (*above == i || above == chosen.begin()) {
      places.push_back({*above, *above, 0});
    } else {
      const std::uint32_t below = *(above - 1);
      places.push_back({below, *above, (axis[i] - axis[below]) / (axis[*above] - axis[below])});
    }
  }
  return places;
}

Levels::Levels(const SliceDescription& slice) : width_(static_cast<std::uint32_t>(slice.axis_b.size())) {
  for (const CoarseAxes& grid : slice.coarse)
    grids_.push_back({places(slice.axis_a, grid.a), places(slice.axis_b, grid.b)});
  std::vector<std::uint32_t> all_a(slice.axis_a.size()), all_b(slice.axis_b.size());
  std::iota(all_a.begin(), all_a.end(), 0u);
  std::iota(all_b.begin(), all_b.end(), 0u);
  grids_.push_back({places(slice.axis_a, all_a), places(slice.axis_b, all_b)});
}

Levels::Corners Levels::around(std::size_t level, std::uint32_t node) const {
  const Place &a = grids_[level].a[node / width_], &b = grids_[level].b[node % width_];
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
