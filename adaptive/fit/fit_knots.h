// A knot table for traced nodes: the rival without mixtures (ESTIMATOR.md, E7).
#pragma once

#include <cstdint>

#include "tress/adaptive/knot_density.h"
#include "tress/adaptive/traced_nodes.h"

namespace tress::adaptive {

struct KnotFit {
  KnotDensity table;              ///< of mass nodes.energy(), without attributes
  double objective = 0;           ///< relative squared L2 against g, by Boole's rule on four points a cell
  std::uint32_t evaluations = 0;  ///< of g: 128, 256 or 512
};

/// 32 knots, doubled up to 128 while the objective is above epsilon/4: what growth of a mixture aims at too.
/// The caller compares the objective with epsilon. Pure and deterministic; never fails.
KnotFit fit_knots(const TracedNodes& nodes, double epsilon);

/// Gives each knot the mean and variance of the attribute over the traced rays, each in proportion to
/// weight (G * density_k hat_k / f)(azimuth), G the blur: the share of the knot's hat in what the ray brings.
KnotDensity with_attributes(const KnotDensity& table, const TracedNodes& nodes);

}  // namespace tress::adaptive
