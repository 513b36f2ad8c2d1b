#include "scene/model/framed_points.h"

#include <algorithm>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>
#include <limits>

namespace tress::scene {
namespace {

/// The largest absolute coordinate.
float size_of(const glm::vec3& x) {
  const glm::vec3 size = glm::abs(x);
  return std::max({size.x, size.y, size.z});
}

/// The beginning of a uniform cubic B-spline with these control points. If the first one mirrors the third, up to
/// rounding of floats, it is the second to the bit.
glm::vec3 end_of_bspline(const glm::vec3& beyond, const glm::vec3& end, const glm::vec3& next) {
  const glm::vec3 bend = beyond - 2.0f * end + next;
  const float largest = std::max({size_of(beyond), size_of(end), size_of(next)});
  constexpr float rounding = 8 * std::numeric_limits<float>::epsilon();
  return size_of(bend) <= rounding * largest ? end : end + bend / 6.0f;
}

/// Whether Bezier segments form one uniform B-spline: each joint is smooth, and both sides give the same control point.
/// The tolerance for rounding in files is a thousandth of the distance to its neighbours.
bool joins_as_bspline(std::span<const glm::vec3> p) {
  constexpr float rounding = 1e-3f;
  if (p.size() < 7) return false;
  for (std::size_t joint = 3; joint + 3 < p.size(); joint += 3) {
    const glm::vec3 before = 2.0f * p[joint - 1] - p[joint - 2], behind = 2.0f * p[joint + 1] - p[joint + 2];
    const float near = size_of(p[joint + 2] - p[joint]) + size_of(p[joint] - p[joint - 2]);
    const glm::vec3 bend = p[joint - 1] - 2.0f * p[joint] + p[joint + 1];
    if (!(size_of(before - behind) <= rounding * near && size_of(bend) <= rounding * near)) return false;
  }
  return true;
}

}  // namespace

void append_framed_points(StrandBasis basis, std::span<const glm::vec3> p, std::vector<glm::vec3>* out) {
  if (basis == StrandBasis::open_bspline && p.size() >= 4) {
    const std::size_t last = p.size() - 1;
    out->push_back(end_of_bspline(p[0], p[1], p[2]));
    out->insert(out->end(), p.begin() + 1, p.end() - 1);
    out->push_back(end_of_bspline(p[last], p[last - 1], p[last - 2]));
  } else if (basis == StrandBasis::bezier && joins_as_bspline(p)) {
    out->push_back(p.front());
    for (std::size_t from = 0; from + 3 < p.size(); from += 3) out->push_back(2.0f * p[from + 1] - p[from + 2]);
    out->push_back(2.0f * p[p.size() - 2] - p[p.size() - 3]);
    out->push_back(p.back());
  } else {
    out->insert(out->end(), p.begin(), p.end());
  }
}

std::vector<std::uint32_t> stray_strands(std::span<const std::uint32_t> first_point,
                                         std::span<const glm::vec3> points) {
  constexpr double middle_share = 0.9;
  constexpr float furthest = 10;
  constexpr std::size_t fewest = 5, most_measured = 10'000;
  const std::size_t strands = first_point.empty() ? 0 : first_point.size() - 1;
  std::vector<std::uint32_t> stray;
  if (strands < fewest) return stray;
  const auto box_of = [&](std::size_t s) {
    Box box{points[first_point[s]], points[first_point[s]]};
    for (std::uint32_t i = first_point[s]; i < first_point[s + 1]; ++i) box.include(points[i]);
    return box;
  };
  std::vector<Box> some;
  for (std::size_t s = 0; s < strands; s += strands / most_measured + 1)
    if (first_point[s] < first_point[s + 1]) some.push_back(box_of(s));
  if (some.size() < fewest) return stray;
  const auto last = static_cast<double>(some.size() - 1);
  const auto high_rank = static_cast<std::size_t>(middle_share * last), low_rank = some.size() - 1 - high_rank;
  Box middle;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<float> ends;
    const auto ranked = [&](glm::vec3 Box::* end, std::size_t rank) {
      ends.clear();
      for (const Box& box : some) ends.push_back((box.*end)[axis]);
      std::nth_element(ends.begin(), ends.begin() + static_cast<std::ptrdiff_t>(rank), ends.end());
      return ends[rank];
    };
    middle.low[axis] = ranked(&Box::low, low_rank);
    middle.high[axis] = ranked(&Box::high, high_rank);
  }
  const float extent = middle.longest_side();
  if (!(extent > 0)) return stray;
  const glm::vec3 low = middle.low - furthest * extent, high = middle.high + furthest * extent;
  for (std::size_t s = 0; s < strands; ++s) {
    const auto first = points.begin() + first_point[s], end = points.begin() + first_point[s + 1];
    const bool is_out = std::any_of(first, end, [&](const glm::vec3& p) {
      return glm::any(glm::lessThan(p, low)) || glm::any(glm::greaterThan(p, high));
    });
    if (is_out) stray.push_back(static_cast<std::uint32_t>(s));
  }
  if (stray.size() > std::max<std::size_t>(1, strands / 10)) stray.clear();
  return stray;
}

void Box::include(const glm::vec3& point) {
  low = glm::min(low, point);
  high = glm::max(high, point);
}

float Box::longest_side() const {
  const glm::vec3 sides = high - low;
  return std::max({sides.x, sides.y, sides.z});
}

std::optional<Box> box_of_strands(StrandBasis basis, std::span<const std::uint32_t> first_point,
                                  std::span<const glm::vec3> points) {
  std::optional<Box> box;
  for_each_framed_point(basis, first_point, points, [&box](const glm::vec3& point) {
    if (!box) box = Box{point, point};
    box->include(point);
  });
  return box;
}

}  // namespace tress::scene
