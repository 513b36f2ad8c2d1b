// Computes which traced rays a knot accounts for: the adjoint of blurring its share of f, on a grid that suits both.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "base/pi.h"
#include "fit/kernels.h"
#include "references/learners/fit_knots.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr double reach = 4;             // of the blur, in sigma: 6e-5 of it lies beyond
constexpr double points_per_sigma = 4;  // the same as for the components of a mixture

/// Mass and first two moments of the attribute at one point of the grid.
using KnotMoments = std::array<double, 3>;
/// The same over the whole grid, one moment after the other.
using Fields = std::array<std::vector<double>, 3>;

/// The rays, each shared between its two neighbours on the grid.
Fields collected(const TracedNodes& nodes, std::size_t points) {
  Fields fields;
  for (std::vector<double>& field : fields) field.assign(points, 0.0);
  for (std::size_t j = 0; j < nodes.size(); ++j) {
    const double at = std::max((nodes.azimuth()[j] / two_pi + 0.5) * static_cast<double>(points), 0.0);
    const auto left = static_cast<std::size_t>(at);
    const double fraction = at - static_cast<double>(left), value = nodes.attribute()[j];
    double moment = nodes.weight()[j];
    for (std::vector<double>& field : fields) {
      field[left % points] += (1 - fraction) * moment;
      field[(left + 1) % points] += fraction * moment;
      moment *= value;
    }
  }
  return fields;
}

/// Blurs each field by the wrapped Gaussian of standard deviation `blur`.
void blur_fields(Fields& fields, double blur) {
  const std::size_t points = fields[0].size();
  const double spacing = two_pi / static_cast<double>(points);
  const auto taps = static_cast<std::size_t>(std::ceil(reach * blur / spacing));
  std::vector<double> kernel(2 * taps + 1);
  for (std::size_t k = 0; k < kernel.size(); ++k) {
    const double d = (static_cast<double>(k) - static_cast<double>(taps)) * spacing / blur;
    kernel[k] = std::exp(-0.5 * d * d);
  }
  std::vector<double> unrolled(points + 2 * taps), smooth(points);
  for (std::vector<double>& field : fields) {
    const std::size_t before = points * (1 + taps / points) - taps;
    for (std::size_t i = 0; i < unrolled.size(); ++i) unrolled[i] = field[(i + before) % points];
    blur_row(unrolled.data(), kernel.data(), kernel.size(), smooth.data(), points);
    field.swap(smooth);
  }
}

}  // namespace

KnotDensity with_attributes(const KnotDensity& table, const TracedNodes& nodes) {
  std::vector<Knot> knots(table.knots().begin(), table.knots().end());
  const std::size_t count = knots.size();
  if (count == 0 || nodes.size() == 0) return table;
  const double wanted =
      std::max(4.0, std::ceil(points_per_sigma * two_pi / nodes.blur_rad() / static_cast<double>(count)));
  const std::size_t a_cell = padded_size(static_cast<std::size_t>(wanted) * count) / count;
  const std::size_t points = a_cell * count;
  Fields fields = collected(nodes, points);
  KnotMoments all{};
  for (std::size_t m = 0; m < all.size(); ++m) {
    for (const double value : fields[m]) all[m] += value;
  }
  blur_fields(fields, nodes.blur_rad());
  std::vector<KnotMoments> moments(count, KnotMoments{});
  for (std::size_t i = 0; i < points; ++i) {
    const std::size_t k = i / a_cell, next = (k + 1) % count;
    const double along = static_cast<double>(i % a_cell) / static_cast<double>(a_cell);
    const double from = (1 - along) * knots[k].density, to = along * knots[next].density;
    if (!(from + to > 0)) continue;
    for (std::size_t m = 0; m < fields.size(); ++m) {
      const double moment = fields[m][i] / (from + to);
      moments[k][m] += from * moment;
      moments[next][m] += to * moment;
    }
  }
  // The kernel was not normalised, so any real mass is far above rounding error.
  for (std::size_t k = 0; k < count; ++k) {
    const KnotMoments& known = moments[k][0] > 1e-9 * all[0] ? moments[k] : all;
    const double mean = known[1] / known[0];
    knots[k].attribute_mean = static_cast<float>(mean);
    knots[k].attribute_variance = static_cast<float>(std::max(0.0, known[2] / known[0] - mean * mean));
  }
  return KnotDensity(std::move(knots));
}

}  // namespace tress::inline v0_2::adaptive
