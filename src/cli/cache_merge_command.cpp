#include "cli/cache_merge_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "cli/cache_output.h"
#include "cli/console.h"
#include "cli/output_path.h"
#include "tress/adaptive/cache.h"

namespace tress::cli {
namespace {

/// The join of all files. Errors are told, all of them.
std::optional<adaptive::TableSnapshot> merge_files(const std::vector<std::filesystem::path>& files) {
  std::optional<adaptive::TableSnapshot> merged;
  std::filesystem::path first;
  bool refused = false;
  for (const std::filesystem::path& file : files) {
    const std::string model = merged ? merged->model : "";
    Result<adaptive::TableSnapshot> image = adaptive::load_cache(file, model);
    if (!image) {
      Error error = image.error();
      if (error.expected.starts_with("model ")) error.expected += " as in " + first.string();
      fail(error.message());
      refused = true;
    } else if (merged) {
      merged = adaptive::merge_caches(*merged, *image);
    } else {
      merged = std::move(*image);
      first = file;
    }
  }
  if (refused) return std::nullopt;
  return merged;
}

bool is_one_of(const std::filesystem::path& file, const std::vector<std::filesystem::path>& files) {
  return std::ranges::any_of(files, [&](const std::filesystem::path& other) {
    std::error_code error;
    return std::filesystem::equivalent(file, other, error) && !error;
  });
}

/// `merged` as the whole of the output; where that is an input too, joined once more, since a session may have saved
/// into it meanwhile.
Result<adaptive::TableSnapshot> write(const CacheMergeSettings& settings, adaptive::TableSnapshot merged) {
  if (is_one_of(settings.output, settings.files)) {
    Result<adaptive::CacheUpdate> update = adaptive::merge_into_cache(settings.output, std::move(merged));
    if (!update) return update.error();
    if (update->refusal) return *update->refusal;
    tell_removed(settings.output, update->removed);
    return std::move(update->image);
  }
  if (std::optional<Error> error = check_cache_output(settings.output)) return *error;
  std::vector<std::filesystem::path> removed;
  if (std::optional<Error> error = adaptive::save_cache(settings.output, merged, &removed)) return *error;
  tell_removed(settings.output, removed);
  return merged;
}

}  // namespace

int run_cache_merge(const CacheMergeSettings& settings) {
  if (const auto error = check_output(settings.output)) {
    fail(error->message());
    return 1;
  }
  std::optional<adaptive::TableSnapshot> merged = merge_files(settings.files);
  if (!merged) return 1;
  const Result<adaptive::TableSnapshot> written = write(settings, std::move(*merged));
  if (!written) {
    fail(written.error().message());
    return 1;
  }
  std::uint64_t rows = 0, converged = 0;
  for (const adaptive::CachedSlice& slice : written->slices) {
    rows += slice.rows.size();
    converged += static_cast<std::uint64_t>(
        std::ranges::count_if(slice.rows, [](const auto& row) { return row.state == adaptive::RowState::converged; }));
  }
  fmt::print("{}: {} files merged, {} pages, {} rows, {} of them converged, hash {}\n", settings.output.string(),
             settings.files.size(), written->slices.size(), rows, converged, adaptive::cache_hash(*written));
  return 0;
}

}  // namespace tress::cli
