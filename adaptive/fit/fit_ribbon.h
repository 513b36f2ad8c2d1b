// The ribbon of largest likelihood for weighted exits (ESTIMATOR.md, E9).
#pragma once

#include <cstdint>

#include "fit/exit_columns.h"
#include "tress/adaptive/ribbon.h"

namespace tress::adaptive {

struct RibbonFit {
  Ribbon ribbon;
  double log_likelihood = 0;  ///< mean of ln f over the exits' weights
};

/// How a ribbon is fitted. Strengths of the prior are numbers of exits of equal weight.
struct RibbonFitRule {
  int first_rounds = 12;  ///< from exits alone
  int rounds = 8;         ///< from an earlier fit
  bool keep_law = false;  ///< of an earlier fit
  double density_prior = 8, mode_prior = 30, scale_prior = 100;
};

/// From an earlier fit of the same part, or from nothing, by the law that is more likely. Exits of some weight.
/// `decays`: of the exits' attributes, each knot's by its share of the light; else they are 1.
RibbonFit fit_ribbon(const ExitColumns& exits, const Ribbon* earlier, bool decays, const RibbonFitRule& rule = {});

}  // namespace tress::adaptive
