// Whether a file can be written where the user wants it: found out before the work, not after it.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "tress/base/error.h"

namespace tress::cli {

/// Tries a temporary file beside what `file` ends in and removes it. Error if the folder is missing or cannot be
/// written, if `file` is a folder or device, or its name too long. `file` itself is not queried.
std::optional<Error> check_output(const std::filesystem::path& file);

/// Where what cannot be written to `file` may go, best first: under its own name, or with a number after it that no
/// file there has, in the nearest folder above that is there, the current one, $HOME, and the folder of temporary
/// files.
std::vector<std::filesystem::path> other_places(const std::filesystem::path& file);

/// Removes what killed saves left beside `file`, just written, and says so.
void remove_leftovers(const std::filesystem::path& file);
/// Says what has been removed.
void tell_removed(const std::filesystem::path& file, const std::vector<std::filesystem::path>& leftovers);

/// Error if the folder of `file` cannot be written, or `file` is there and is no warm cache: what is replaced must be
/// one.
std::optional<Error> check_cache_output(const std::filesystem::path& file);

}  // namespace tress::cli
