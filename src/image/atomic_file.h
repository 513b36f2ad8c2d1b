// Files that appear whole or not at all.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "tress/adaptive/error.h"

namespace tress::image {

/// A name beside `file`, unused by other processes and threads, for what will become `file`.
std::filesystem::path temporary_beside(const std::filesystem::path& file);

/// Flushes `temporary` to the disk and renames it to `file`. On failure removes it and leaves `file` as it was.
std::optional<Error> publish_file(const std::filesystem::path& temporary, const std::filesystem::path& file);

/// Writes `bytes` to a temporary file and publishes it.
std::optional<Error> write_file_atomically(const std::filesystem::path& file, const std::string& bytes);

}  // namespace tress::image
