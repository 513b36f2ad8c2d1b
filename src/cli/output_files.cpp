#include "cli/output_files.h"

#include <fmt/format.h>

#include <cstdlib>
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

std::vector<std::filesystem::path> other_places(const std::filesystem::path& file) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path asked = fs::weakly_canonical(fs::absolute(file, error), error).parent_path();
  std::vector<fs::path> folders;
  fs::path above = asked.parent_path();
  while (!fs::is_directory(above, error) && above.has_relative_path()) above = above.parent_path();
  folders.push_back(above);
  folders.push_back(fs::current_path(error));
  if (const char* home = std::getenv("HOME"); home != nullptr && *home != 0) folders.emplace_back(home);
  folders.push_back(fs::temp_directory_path(error));
  std::vector<fs::path> places;
  for (const fs::path& folder : folders) {
    if (folder.empty() || folder == asked || !fs::is_directory(folder, error)) continue;
    fs::path place = folder / file.filename();
    for (int number = 1; fs::exists(fs::symlink_status(place, error)) && number < 1000; ++number)
      place = folder / fmt::format("{}-{}{}", file.stem().string(), number, file.extension().string());
    if (!fs::exists(fs::symlink_status(place, error))) places.push_back(place);
  }
  return places;
}

void log_removed(const std::filesystem::path& file, const std::vector<std::filesystem::path>& leftovers) {
  for (const std::filesystem::path& leftover : leftovers) {
    log_note(fmt::format("{}: removed {}, left by a save that was killed", file.string(), leftover.string()));
  }
}

void remove_leftovers(const std::filesystem::path& file) { log_removed(file, tress::remove_leftovers(file)); }

void log_left_out(const std::filesystem::path& file, const adaptive::CacheContents& contents) {
  if (contents.knot_rows == 0) return;
  log_note(fmt::format("{}: {} rows of knots are left out: they are learned anew, and a save keeps none of them",
                       file.string(), contents.knot_rows));
}

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
