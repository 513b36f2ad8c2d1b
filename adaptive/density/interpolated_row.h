// A row between others: their lobes moved, not mixed.
#pragma once

#include <span>

#include "tress/adaptive/ribbon.h"

namespace tress::adaptive {

struct WeightedRow {
  const DecodedRow* row;
  float weight;  ///< >= 0; those of all rows add up to 1
};

/// Knot by knot: places by the shorter way round, densities, modes and decays linearly, scales by their logarithms,
/// masses linearly. Of parts that only some rows have the shape is theirs. The law is that of the largest weight;
/// scales of another law are taken at the ratio at which both look alike. A row of weight 1 is returned to the bit.
/// Pure. One to four rows of equally many parts.
RibbonRow interpolate_rows(std::span<const WeightedRow> rows);

}  // namespace tress::adaptive
