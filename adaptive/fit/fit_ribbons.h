// Fits the ribbons of largest likelihood to the weighted exits of a row (ESTIMATOR.md, E9).
#pragma once

#include <array>
#include <cstdint>

#include "fit/layer_step.h"
#include "fit/row_exits.h"
#include "tress/adaptive/ribbon.h"

namespace tress::inline v0_2::adaptive {

/// The rule by which the ribbons of a row are fitted.
struct RibbonFitRule {
  int rounds = 6;            ///< over all exits
  int thin_rounds = 0;       ///< before these, over some of the exits (thin_exits)
  bool from_parent = false;  ///< whether a part that has a parent starts from it; others start from moments
  bool parents_law = false;  ///< whether a part that has a parent keeps its law; others take the likelier law
  float kappa = 0;           ///< number of exits that a parent counts for, in fits from a parent
  RibbonPrior prior;
  float first_broad_share = 0.01f;  ///< at the start, of parts without parent or second peak

  /// The rule for this many paths. A fit to few paths depends on its start: it starts from the parent and is held to
  /// it, or, without a parent, starts from moments. With more paths, such a start would only trap the fit in a poor
  /// optimum. The broad layer finds what the main one misses from a large share on, which few paths do not take back.
  static RibbonFitRule of(std::uint64_t paths, bool has_parent, float kappa) {
    constexpr std::uint64_t many = 2048;
    if (paths >= many) return {4, 8, false, false, 0, {}, 0.2f};
    return has_parent ? RibbonFitRule{3, 0, true, true, kappa, {}} : RibbonFitRule{};
  }
};

struct FittedRibbons {
  /// The ribbons have decays. A part without light has uniform density.
  std::array<Ribbon, RowExits::most_parts> ribbon;
};

/// A parent may be null. The decays of each knot are means over its share of the exits.
using PartParents = std::array<const Ribbon*, RowExits::most_parts>;
FittedRibbons fit_ribbons(const RowExits& exits, const PartParents& parents, const RibbonFitRule& rule);

}  // namespace tress::inline v0_2::adaptive
