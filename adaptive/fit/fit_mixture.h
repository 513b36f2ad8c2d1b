// Fits a mixture to the exact pairs of a sketch: Levenberg-Marquardt, components grown while they pay.
#pragma once

#include <span>
#include <vector>

#include "observations/sketch.h"
#include "tress/adaptive/mixture.h"
#include "tress/adaptive/traced_nodes.h"

namespace tress::inline v0_2::adaptive {

struct FitSettings {
  double epsilon = 0.01;
  int max_components = 8;
  /// Whether a warm fit that stays above epsilon/4 is fitted once more from D = 0, to keep the better one.
  bool restart = true;
};

struct Fit {
  Mixture mixture;       ///< without absorption; its attributes are zero
  double objective = 0;  ///< R = o N^2/(N-4D-1)^2 / L on the pairs it was fitted to; growth stops by it
};

/// pairs: sorted by azimuth. energy: known mass of g. variation: max(integral (g-mean)^2, 1e-3/2pi), 1/rad. warm: the
/// fit to start from, null for a cold one. Pure and deterministic. Never fails: the worst answer is a flat mixture of
/// the right energy. Every result is within the constraints (weights >= 0, s in [0.004, 0.5], mu in [-pi, pi)).
Fit fit_mixture(std::span<const ObservedPair> pairs, double energy, double variation, const Mixture* warm,
                const FitSettings& settings);

/// Gives each component (and the uniform part) the responsibility-weighted mean and variance of the attribute over the
/// traced rays. The responsibility of component d at azimuth x is weight_d p_d(x)/f(x), blurred as g is.
void assign_attributes(Mixture& mixture, const TracedNodes& nodes);

}  // namespace tress::inline v0_2::adaptive
