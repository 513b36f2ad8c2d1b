// Finds the cells of distribution functions into which exits fall, many at once.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "tress/adaptive/ribbon.h"

namespace tress::inline v0_2::adaptive {

/// The ribbons of a row as the search for cells reads them.
struct CellTables {
  static constexpr std::size_t parts = RibbonRow::most_parts;
  static constexpr std::size_t main_segments = Ribbon::main_knots + 1;  ///< the last: from -pi to the first knot
  /// All values but width and below are linear along the segment. They are given at its start; `more_` is the
  /// difference to its end.
  struct Segment {
    float x0, inverse_width, below, width;  ///< below: the mass of the layer from -pi to the segment
    float density, more_density, mode, more_mode, scale_below, more_below, scale_above, more_above;
  };
  alignas(32) std::array<float, parts * Ribbon::main_knots> azimuth{};  ///< azimuths of the main knots
  std::array<Segment, parts * main_segments> main{};
  std::array<Segment, parts * Ribbon::broad_knots> broad{};
  std::array<float, parts> is_normal{};  ///< 1 if the main layer's heights are normally distributed, else 0

  void set(std::size_t part, const Ribbon& ribbon);
  /// The azimuths where a main segment, counted over all parts, begins and ends.
  std::array<float, 2> ends(std::int32_t part, std::int32_t segment) const;
};

/// Finds the cell of each exit, floor(us u) vs + floor(vs v), with (u, v) as in Ribbon::cdf() to 1e-6. The cells of a
/// part follow those of the parts before it. x in [-pi, pi). All arrays have a multiple of 16 elements.
void find_cells(const CellTables& tables, std::int32_t us, std::int32_t vs, std::size_t n, const float* x,
                const float* t, const std::int32_t* part, std::int32_t* cell);

}  // namespace tress::inline v0_2::adaptive
