// Whether a warm cache can be written where the user wants it.
#pragma once

#include <filesystem>
#include <optional>

#include "tress/base/error.h"

namespace tress::cli {

/// Error if the folder of `file` cannot be written, or `file` is there and is no warm cache: what is replaced must be
/// one.
std::optional<Error> check_cache_output(const std::filesystem::path& file);

}  // namespace tress::cli
