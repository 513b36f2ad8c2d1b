// The contents of a report on runs, from their telemetry (adaptive/telemetry/README.md).
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "tress/base/error.h"

namespace tress::live {

/// A run is reported as converged if fits answered at least this share of the queries of its last pass.
inline constexpr double converged_share = 0.95;
/// Number of rows that are listed, those of most light first.
inline constexpr std::size_t most_rows_listed = 50;

/// Reads the runs of one file, in order; there are several if it covers several frames. Each is an object of name,
/// header, passes, summary (null if the run was killed), verdict {good, text}, cost, cache, left {text, rows}. A last
/// line that was cut off is left out. Error if the file cannot be read or is no telemetry.
Result<std::vector<nlohmann::ordered_json>> report_data(const std::filesystem::path& file);

}  // namespace tress::live
