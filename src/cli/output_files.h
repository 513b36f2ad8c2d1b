// Checks before the work starts that a file can be written where the user wants it.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "tress/adaptive/cache.h"
#include "tress/base/error.h"

namespace tress::cli {

/// Makes and removes a temporary file beside the file to which `file` links. Error if the folder is missing or cannot
/// be written, if `file` is a folder or device, or if its name is too long. `file` itself is not touched.
std::optional<Error> check_output(const std::filesystem::path& file);

/// Other places for a file that cannot be written to `file`, best first. They have its own name, or that name with an
/// unused number, in the nearest existing folder above, the current folder, $HOME, and the folder of temporary files.
std::vector<std::filesystem::path> other_places(const std::filesystem::path& file);

/// Removes the files that killed saves left beside `file`, which was just written, and logs it.
void remove_leftovers(const std::filesystem::path& file);
/// Logs the removed files.
void log_removed(const std::filesystem::path& file, const std::vector<std::filesystem::path>& leftovers);

/// Logs how many rows of the cache are of a kind that is no longer read, and so are learned anew.
void log_left_out(const std::filesystem::path& file, const adaptive::CacheContents& contents);

/// Error if the folder of `file` cannot be written, or if `file` exists and is no warm cache: only a cache may be
/// replaced.
std::optional<Error> check_cache_output(const std::filesystem::path& file);

}  // namespace tress::cli
