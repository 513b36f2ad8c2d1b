#include "cli/output_files.h"

#include <fmt/format.h>

#include <string>
#include <system_error>
#include <vector>

#include "cli/console.h"
#include "tress/adaptive/cache.h"
#include "tress/base/replace_file.h"

namespace tress::cli {

std::optional<Error> check_output(const std::filesystem::path& file) {
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored)) return Error{file.string(), "", "a file to write", "a folder"};
  const std::filesystem::path parent = behind_links(file).parent_path();
  const std::string folder = parent.empty() ? "." : parent.string();
  if (!std::filesystem::is_directory(folder, ignored)) {
    return Error{file.string(), "folder " + folder, "a folder that can be written", "no such folder"};
  }
  return check_replaceable(file);
}

void tell_removed(const std::filesystem::path& file, const std::vector<std::filesystem::path>& leftovers) {
  for (const std::filesystem::path& leftover : leftovers) {
    log_note(fmt::format("{}: removed {}, left by a save that was killed", file.string(), leftover.string()));
  }
}

void remove_leftovers(const std::filesystem::path& file) { tell_removed(file, tress::remove_leftovers(file)); }

std::optional<Error> check_cache_output(const std::filesystem::path& file) {
  if (auto error = check_output(file)) return error;
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) return std::nullopt;
  const auto there = adaptive::CacheFile::open(file, "");
  if (there) return std::nullopt;
  Error error = there.error();
  error.expected = "a new name, or a warm cache to replace: " + error.expected;
  return error;
}

}  // namespace tress::cli
