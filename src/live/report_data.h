// What a report says of runs, from their telemetry (adaptive/telemetry/README.md).
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "tress/base/error.h"

namespace tress::live {

/// Of the queries of its last pass, answered by fits: from here on a run is called converged.
inline constexpr double converged_share = 0.95;
/// Rows that are listed, those of most light first.
inline constexpr std::size_t most_rows_listed = 50;

/// The runs of one file, in order: more than one where it tells of many frames. Each is an object of name, header,
/// passes, summary (null where the run was killed), verdict {good, text}, cost, cache, left {text, rows}. A last line
/// that was cut off is left out. Error if the file cannot be read or is no telemetry.
Result<std::vector<nlohmann::ordered_json>> report_data(const std::filesystem::path& file);

}  // namespace tress::live
