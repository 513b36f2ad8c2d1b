// Whether a file can be written where the user wants it: found out before the work, not after it.
#pragma once

#include <filesystem>
#include <optional>

#include "tress/adaptive/error.h"

namespace tress::cli {

/// Tries a temporary file in the folder of `file` and removes it. Error if the folder is missing or cannot be written,
/// or `file` is a folder. `file` itself is not touched.
std::optional<Error> check_output(const std::filesystem::path& file);

}  // namespace tress::cli
