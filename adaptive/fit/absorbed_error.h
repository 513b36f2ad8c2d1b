// The error of a fit once fit and target decay with the attribute: that of the colored row. Epsilon bounds the error of
// the clear row.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tress/adaptive/mixture.h"
#include "tress/adaptive/target.h"
#include "tress/adaptive/traced_nodes.h"

namespace tress::inline v0_2::adaptive {

/// The rates at which the error is evaluated: all of them if there are at most four, otherwise those at 0, 1/3, 2/3 and
/// 1 of their ranks. rates: ascending, distinct.
std::vector<float> representative_rates(std::span<const float> rates);

/// Whether the row is one of the one in eight that are measured, chosen by key and node alone. To measure all would
/// take half as much CPU again as their fits.
bool stands_for_others(const SliceKey& slice, std::uint32_t node);

/// Returns the integral of (g_s - f_s)^2 over the integral of (g_s - mean g_s)^2, at decay rate s = `rate` > 0 (per
/// unit of the attribute). g_s = sum_j w_j exp(-s a_j) G(x - phi_j); f_s has each part's weight times decayed_share()
/// of its moments. Neither is scaled to the other's mass. Rows that vary by less than 0.1 % (rms) of their mean count
/// as varying by that much. Empty if absorption leaves less than 1e-30 of every ray. Any thread; finite, >= 0.
std::optional<double> absorbed_error(const Mixture& fit, const TracedNodes& nodes, float rate);

}  // namespace tress::inline v0_2::adaptive
