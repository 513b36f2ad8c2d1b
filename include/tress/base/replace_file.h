// Replaces a file so that it is whole, old or new, at every moment.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tress/base/error.h"

namespace tress::inline v0_2 {

/// The path that a save replaces: `file`, or the end of a chain of links from it, whether that exists or not.
std::filesystem::path behind_links(const std::filesystem::path& file);

/// Writes `bytes` to a temporary file FILE.tmp-PID-N beside the end of `file`'s links, flushes it, renames it and
/// flushes the folder. Links stay links; permissions, group and owner of an old file are kept as far as the process
/// may. On failure the old file is unchanged and nothing is left beside it, except if only the last flush fails: the
/// new file is then in place. Refuses to replace anything but a regular file. `name`: the name in errors, if not
/// `file`. Any thread.
std::optional<Error> replace_file(const std::filesystem::path& file, const std::string& bytes,
                                  const std::string& name = {});

/// Checks that replace_file could begin: makes such a temporary file and removes it. Finds a missing or read-only
/// folder, a name that is too long, a device or folder of that name.
std::optional<Error> check_replaceable(const std::filesystem::path& file);

/// Removes the temporary files that killed processes left beside the end of `file`'s links, which was just replaced,
/// and returns their names. A live writer locks its file, which is kept. For file systems that only pretend to lock,
/// files younger than a minute, by the clock of the file system, are kept as well.
std::vector<std::filesystem::path> remove_leftovers(const std::filesystem::path& file);

}  // namespace tress::inline v0_2
