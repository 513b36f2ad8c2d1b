// The rival `table` where bench programs learn rows: a row of knots is made of its g alone, whatever a render asks.
#pragma once

#include <cstdint>
#include <ctime>

#include "references/learners/fit_knots.h"
#include "tress/adaptive/traced_nodes.h"

namespace tress::bench {

struct KnotRow {
  adaptive::KnotDensity table;  ///< with attributes
  double objective = 0;         ///< relative squared L2
  bool converged = false;       ///< objective <= epsilon; a service would answer the others by g
};

/// Makes rows, and counts what they cost.
struct KnotFitter {
  double epsilon = 0.01;
  std::uint64_t g_evaluations = 0;
  double cpu_seconds = 0;

  KnotRow fit(const adaptive::TracedNodes& nodes) {
    const std::clock_t start = std::clock();
    adaptive::KnotFit made = adaptive::fit_knots(nodes, epsilon);
    KnotRow row{adaptive::with_attributes(made.table, nodes), made.objective, made.objective <= epsilon};
    g_evaluations += made.evaluations;
    cpu_seconds += static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    return row;
  }
};

}  // namespace tress::bench
