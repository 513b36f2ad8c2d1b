// A file that is there whole, old or new, at every moment.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tress/base/error.h"

namespace tress {

/// The path that a save replaces: `file`, or what a chain of links from it ends in, there or not.
std::filesystem::path behind_links(const std::filesystem::path& file);

/// Writes `bytes` to a temporary file FILE.tmp-PID-N beside what `file` ends in, flushes it, renames it and flushes the
/// folder. Links stay links; permissions, group and owner of an old file are kept as far as the process may. On failure
/// the old file is as it was and nothing is left beside it, but where only the last flush fails: the new one is then in
/// place. Refuses to replace what is no regular file. `name`: what errors call it, if not by `file`. Any thread.
std::optional<Error> replace_file(const std::filesystem::path& file, const std::string& bytes,
                                  const std::string& name = {});

/// Whether replace_file could begin: makes such a temporary file and removes it. Finds a missing or read-only folder, a
/// name that is too long, a device or folder of that name.
std::optional<Error> check_replaceable(const std::filesystem::path& file);

/// Removes the temporary files that killed processes left beside what `file`, just replaced, ends in, and returns their
/// names. Those of a writer that lives are locked by it. For file systems that merely pretend to lock, what is younger
/// than a minute, by the clock of the file system, stays as well.
std::vector<std::filesystem::path> remove_leftovers(const std::filesystem::path& file);

}  // namespace tress
