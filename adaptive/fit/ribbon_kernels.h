// The loops over exits that a fit and a test of ribbons spend their time in, for the widest instruction set that the
// machine has.
#pragma once

#include <cstddef>

#include "tress/adaptive/ribbon.h"

namespace tress::adaptive {

/// Arrays of exits are readable this many floats past their end, and finite there.
constexpr std::size_t ribbon_lanes = 16;

/// What lies between two knots of a layer: everything is linear in the azimuth. [0] at x0, [1] at the other end.
struct RibbonSegment {
  float x0 = 0, inverse_width = 0;  ///< of the azimuth, radians
  float density[2]{}, mode[2]{}, scale_below[2]{1, 1}, scale_above[2]{1, 1};
};

/// Exits between two knots of either layer: azimuths, heights and weights.
struct RibbonExits {
  const float *x, *t, *w;
  std::size_t n;
};

/// Sums over exits of what moves the knots of a segment; h: the hat of either knot, 1 - s and s at the exit, r: the
/// layer's share of the density f there.
struct SegmentSums {
  double light[2]{};                                     ///< w h law/f
  double mode[2]{}, scale_below[2]{}, scale_above[2]{};  ///< w r h times the derivative of ln law
  double information[3]{};  ///< w r/(s_below s_above) times the squares of the hats, their product in the middle
};

/// Adds the exits' sums of both layers.
void add_exits(const RibbonSegment& main, HeightLaw main_law, const RibbonSegment& broad, const RibbonExits& exits,
               SegmentSums& main_sums, SegmentSums& broad_sums);

/// Each exit's f, and the main layer's share of it. Writes up to ribbon_lanes past the end.
void evaluate_exits(const RibbonSegment& main, HeightLaw main_law, const RibbonSegment& broad, const RibbonExits& exits,
                    float* density, float* main_share);

}  // namespace tress::adaptive
