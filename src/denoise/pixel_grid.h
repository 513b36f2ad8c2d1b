// Numbers and colors by pixel, row by row from the top.
#pragma once

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <glm/vec3.hpp>
#include <vector>

namespace tress::denoise {

struct Grid {
  int width = 0, height = 0;
  std::size_t size() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
  /// The index of the nearest pixel within the picture.
  std::size_t nearest(int x, int y) const { return index(std::clamp(x, 0, width - 1), std::clamp(y, 0, height - 1)); }
};

using Colors = std::vector<glm::dvec3>;
using Numbers = std::vector<double>;

/// Calls the work for every row, in parallel.
template <class Work>
void for_rows(const Grid& grid, const Work& work) {
  tbb::parallel_for(0, grid.height, [&](int y) {
    for (int x = 0; x < grid.width; ++x) work(x, y, grid.index(x, y));
  });
}

/// The mean over the square of pixels around each; beyond the border the nearest pixel counts.
template <class Value>
std::vector<Value> smoothed(const Grid& grid, const std::vector<Value>& values, int to_each_side) {
  std::vector<Value> rows(values.size()), all(values.size());
  const double scale = 1.0 / (2 * to_each_side + 1);
  for_rows(grid, [&](int x, int y, std::size_t here) {
    Value sum(0);
    for (int d = -to_each_side; d <= to_each_side; ++d) sum += values[grid.nearest(x + d, y)];
    rows[here] = sum * scale;
  });
  for_rows(grid, [&](int x, int y, std::size_t here) {
    Value sum(0);
    for (int d = -to_each_side; d <= to_each_side; ++d) sum += rows[grid.nearest(x, y + d)];
    all[here] = sum * scale;
  });
  return all;
}

/// The sums over the square of pixels around each, without those beyond the border.
inline Numbers sums_around(const Grid& grid, const Numbers& values, int to_each_side) {
  Numbers rows(values.size()), all(values.size());
  for_rows(grid, [&](int x, int y, std::size_t here) {
    for (int at = std::max(x - to_each_side, 0); at <= std::min(x + to_each_side, grid.width - 1); ++at)
      rows[here] += values[grid.index(at, y)];
  });
  for_rows(grid, [&](int x, int y, std::size_t here) {
    for (int at = std::max(y - to_each_side, 0); at <= std::min(y + to_each_side, grid.height - 1); ++at)
      all[here] += rows[grid.index(x, at)];
  });
  return all;
}

inline double mean_of(const glm::dvec3& x) { return (x.x + x.y + x.z) / 3; }

}  // namespace tress::denoise
