// The table of rows as the live page shows it.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>

#include "tress/adaptive/service.h"

namespace tress::cli {

/// Slices that are told at most, those added first.
inline constexpr std::uint32_t most_slices_told = 48;

/// {"slices": [{name, name_a, name_b, a, b, states, error, light}]}: nodes at the given degrees; `states` a letter for
/// each node, a * size of b + b: . absent, o open, c converged, r refused. Between passes.
nlohmann::ordered_json table_told(const adaptive::Service& service);

/// The row at a node: words, command, and of densities phi_deg (from the direction of the light), target, fit and the
/// parts of the fit (its components and the uniform part) in 1/rad, of hair without color. Between passes. Any numbers
/// may be asked.
nlohmann::ordered_json row_told(const adaptive::Service& service, std::uint32_t slice, std::uint32_t node);

}  // namespace tress::cli
