// What one pass did to one row.
#pragma once

#include <cstdint>
#include <memory>

#include "observations/fixed_moments.h"
#include "table/slice.h"
#include "tress/adaptive/cache.h"
#include "tress/adaptive/traced_nodes.h"

namespace tress::inline v0_2::adaptive {

struct RowOutcome {
  std::uint64_t g_evaluations = 0, validation_draws = 0, refits = 0, bad_fits = 0, traces = 0;
  std::uint32_t failed = 0;  ///< tests that a row of samples did not pass
  bool changed = false, converged = false, audit_failed = false, reopened = false;
  const CachedRow* cached = nullptr;         ///< the cached row that answers from now on, without learning
  double absorbed_error = -1;                ///< largest error of a row that converged, at the decay rates of its slice
  Moments weights;                           ///< moments of g/(q energy) of the scores
  std::unique_ptr<const TracedNodes> nodes;  ///< traced for a row of a density that failed its audit
  // One of these is set for a row of samples that has learned.
  std::unique_ptr<const RibbonAnswer> ribbons;
  bool refused = false;
};

}  // namespace tress::inline v0_2::adaptive
