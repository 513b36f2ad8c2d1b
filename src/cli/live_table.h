// The table of rows for the live page.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>

#include "tress/adaptive/service.h"

namespace tress::cli {

/// Largest number of slices that are sent, those added first.
inline constexpr std::uint32_t most_slices = 48;

/// {"slices": [{name, name_a, name_b, a, b, states, error, light}]}: nodes at the given degrees. `states` has a letter
/// for each node, at a * size of b + b: . absent, o open, c converged, r refused. Between passes.
nlohmann::ordered_json table_json(const adaptive::Service& service);

/// The row at a node: words and command. For densities also phi_deg (from the direction of the light), target, fit and
/// the parts of the fit (its components and the uniform part) in 1/rad, for hair without color. Between passes. Any
/// numbers may be given.
nlohmann::ordered_json row_json(const adaptive::Service& service, std::uint32_t slice, std::uint32_t node);

}  // namespace tress::cli
