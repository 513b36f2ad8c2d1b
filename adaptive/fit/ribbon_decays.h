// What absorption leaves of a fitted ribbon's light, knot by knot.
#pragma once

#include <span>
#include <vector>

#include "fit/ribbon_layer.h"
#include "tress/adaptive/ribbon.h"

namespace tress::adaptive {

/// Writes the decays of the knots: each the mean of its share of the light. main_share: of each exit, the share of the
/// main layer (evaluate_exits).
void write_decays(const RibbonLight& light, const MainLayer& main_layer, const BroadLayer& broad_layer,
                  const std::vector<float>& main_share, std::span<RibbonKnot> main, std::span<RibbonKnot> broad);

}  // namespace tress::adaptive
