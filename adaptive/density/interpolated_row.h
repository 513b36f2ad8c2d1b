// A row interpolated between others: their lobes are moved, not mixed.
#pragma once

#include <span>

#include "tress/adaptive/ribbon.h"

namespace tress::inline v0_2::adaptive {

struct WeightedRow {
  const DecodedRow* row;
  float weight;  ///< >= 0; those of all rows add up to 1
};

/// Interpolates knot by knot: azimuths by the shorter way round; densities, modes, decays and masses linearly; scales
/// by their logarithms. A part that only some rows have takes its shape from those. The law is that of the row of
/// largest weight; scales of another law are converted by the ratio at which both look alike. A row of weight 1 is
/// returned to the bit. Pure. Takes one to four rows of equally many parts.
RibbonRow interpolate_rows(std::span<const WeightedRow> rows);

}  // namespace tress::inline v0_2::adaptive
