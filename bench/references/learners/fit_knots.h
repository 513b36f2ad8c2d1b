// A knot table for traced nodes: the alternative to mixtures (bench/references/KNOTS.md).
#pragma once

#include <cstdint>

#include "references/learners/knot_density.h"
#include "tress/adaptive/traced_nodes.h"

namespace tress::inline v0_2::adaptive {

struct KnotFit {
  KnotDensity table;              ///< its mass is nodes.energy(); it has no attributes
  double objective = 0;           ///< relative squared L2 against g, by Boole's rule on four points per cell
  std::uint32_t evaluations = 0;  ///< number of evaluations of g: 128, 256 or 512
};

/// Fits 32 knots, doubled up to 128 while the objective is above epsilon/4, which is also the aim of growing a mixture.
/// The caller compares the objective with epsilon. Pure and deterministic; never fails.
KnotFit fit_knots(const TracedNodes& nodes, double epsilon);

/// Gives each knot the mean and variance of the attribute over the traced rays. A ray is weighted by weight (G *
/// density_k hat_k / f)(azimuth), G being the blur: the share of the knot's hat in the ray's light.
KnotDensity with_attributes(const KnotDensity& table, const TracedNodes& nodes);

}  // namespace tress::inline v0_2::adaptive
