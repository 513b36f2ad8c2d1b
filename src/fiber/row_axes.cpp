#include "fiber/row_axes.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "tress/fiber/elliptical_model.h"

namespace tress::inline v0_2::fiber {
namespace {

constexpr double quarter_turn = std::numbers::pi / 2;

}  // namespace

std::vector<float> azimuth_axis(float eccentricity, float sigma_rad) {
  if (eccentricity >= 1) return {0.0f};
  const double step = std::max(sigma_rad, smallest_grid_sigma) / 3.0;
  // The tolerance avoids an extra node if a sigma of whole degrees divides the quarter turn up to rounding.
  const int steps = std::max(1, static_cast<int>(std::ceil(quarter_turn / step - 1e-3)));
  std::vector<float> axis;
  for (int i = 0; i <= steps; ++i) axis.push_back(static_cast<float>(quarter_turn * i / steps));
  return axis;
}

std::vector<float> inclination_axis() {
  constexpr int uniform_nodes = 26;
  constexpr double last_uniform = 0.04;
  std::vector<double> cosine;
  for (int i = 0; i < uniform_nodes; ++i) cosine.push_back(1 - (1 - last_uniform) * i / (uniform_nodes - 1));
  for (const double c : {0.02, 0.01, std::cos(89.9 * std::numbers::pi / 180)}) cosine.push_back(c);
  std::vector<float> axis;
  for (const double c : cosine) axis.push_back(static_cast<float>(std::acos(c)));
  return axis;
}

adaptive::SliceDescription elliptical_slice(int slice_lobe, float eta, float eccentricity, float sigma_rad) {
  adaptive::SliceDescription slice;
  slice.key.lobe = static_cast<std::uint32_t>(slice_lobe);
  slice.key.parameters = {eta, eccentricity, sigma_rad};
  slice.axis_a = azimuth_axis(eccentricity, sigma_rad);
  slice.axis_b = inclination_axis();
  slice.blur_rad = sigma_rad;
  return slice;
}

RowGrid::RowGrid(const adaptive::SliceDescription& slice)
    : last_a_(static_cast<std::uint32_t>(slice.axis_a.size() - 1)),
      last_b_(static_cast<std::uint32_t>(slice.axis_b.size() - 1)),
      steps_per_radian_(static_cast<float>(last_a_ / quarter_turn)) {
  int lines = 0;
  double slope = 0;
  for (std::size_t b = 0; b < last_b_; ++b) {
    const auto before = static_cast<double>(most_ - quarter_cosine(slice.axis_b[b]));
    const auto after = static_cast<double>(most_ - quarter_cosine(slice.axis_b[b + 1]));
    const double step = 1 / (after - before);
    if (!(step > slope * (1 + 1e-3))) continue;  // it is the same line, apart from rounding of the axis to floats
    assert(lines < 4);
    slope = step;
    from_[lines] = static_cast<float>(static_cast<double>(b) - before * step);
    steps_[lines++] = static_cast<float>(step);
  }
}

}  // namespace tress::inline v0_2::fiber
