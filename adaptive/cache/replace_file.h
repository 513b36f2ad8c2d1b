// A file that is there whole, old or new, at every moment.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tress/adaptive/error.h"

namespace tress::adaptive {

/// Writes `bytes` to a temporary file beside `target`, flushes it, renames it to `target` and flushes the folder. Keeps
/// the permissions of the old file. On failure the old file is as it was and nothing is left beside it, but where only
/// the last flush fails: the new one is then in place. `target`: no link. `name`: what errors call it.
std::optional<Error> replace_file(const std::filesystem::path& target, const std::string& bytes,
                                  const std::string& name);

/// Removes the temporary files that killed processes left beside `target`, and returns their names. Only for one who
/// keeps all others from replacing it; and, should the file system merely pretend to lock, only those a minute older
/// than `target`, just written, by the clock of that file system.
std::vector<std::filesystem::path> remove_leftovers(const std::filesystem::path& target);

}  // namespace tress::adaptive
