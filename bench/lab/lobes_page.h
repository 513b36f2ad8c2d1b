// The lobe viewer: rows beside their targets, and the far fields of models side by side, as one page.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

namespace tress::lab {

/// Writes the page. rows: of row_json(). far_fields: of far_field_json(), of the same fiber and bins. Exit status; what
/// went wrong is reported.
int write_lobes(const std::filesystem::path& file, const std::vector<nlohmann::ordered_json>& rows,
                const std::vector<nlohmann::ordered_json>& far_fields);

}  // namespace tress::lab
