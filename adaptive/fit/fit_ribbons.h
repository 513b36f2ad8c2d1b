// The ribbons of largest likelihood for the weighted exits of a row (ESTIMATOR.md, E9).
#pragma once

#include <array>
#include <cstdint>

#include "fit/layer_step.h"
#include "fit/row_exits.h"
#include "tress/adaptive/ribbon.h"

namespace tress::adaptive {

/// How the ribbons of a row are fitted.
struct RibbonFitRule {
  int rounds = 4;
  bool from_parent = false;  ///< starts from the parent of a part that has one, else from the moments of its exits
  bool parents_law = false;  ///< of a part that has a parent; else the likelier law
  float kappa = 0;           ///< exits that a parent counts for; of fits from a parent
  RibbonPrior prior;

  /// From so few paths that the start is seen in the result: from the parent and held to it, or, without one, from
  /// moments. With more paths a start would only be a place to get stuck in.
  static RibbonFitRule of(std::uint64_t paths, bool has_parent, float kappa) {
    constexpr std::uint64_t many = 2048;
    if (paths >= many) return {12, false, false, 0, {}};
    return has_parent ? RibbonFitRule{3, true, true, kappa, {}} : RibbonFitRule{};
  }
};

struct FittedRibbons {
  /// The ribbons have decays. A part without light has the uniform density.
  std::array<Ribbon, RowExits::most_parts> ribbon;
  std::array<double, RowExits::most_parts> log_likelihood{};  ///< mean of ln f over the exits' weights
};

/// A parent may be null. Of each knot's light the means of the decays are told, by its share of the exits.
using PartParents = std::array<const Ribbon*, RowExits::most_parts>;
FittedRibbons fit_ribbons(const RowExits& exits, const PartParents& parents, const RibbonFitRule& rule);

}  // namespace tress::adaptive
