// tress cache merge: merges many warm caches into one.
#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "cli/commands.h"
#include "cli/console.h"
#include "cli/output_files.h"
#include "tress/adaptive/cache.h"

namespace tress::cli {
namespace {

struct CacheMergeSettings {
  std::vector<std::filesystem::path> files;  ///< at least one; any order, duplicates and common ancestors allowed
  std::filesystem::path output;              ///< may be one of `files`; any other existing cache is replaced
};

/// Any number of caches merged into one. Its parts form a tree, so that a row passes few of them.
class ManyCaches {
 public:
  /// Opens the files and logs all errors; false if there was one.
  bool open(const std::vector<std::filesystem::path>& files) {
    bool refused = false;
    for (const std::filesystem::path& file : files) {
      const std::string model = parts_.empty() ? "" : parts_.front()->model();
      Result<std::unique_ptr<adaptive::CacheFile>> cache = adaptive::CacheFile::open(file, model);
      if (cache) {
        if (parts_.empty()) first_ = file;
        log_left_out(file, (*cache)->contents());
        parts_.push_back(std::move(*cache));
        continue;
      }
      Error error = cache.error();
      if (error.expected.starts_with("model ")) error.expected += " as in " + first_.string();
      log_error(error.message());
      refused = true;
    }
    return !refused;
  }

  /// The files of open(), merged.
  adaptive::RowSource& joined() {
    std::size_t begin = 0;
    for (std::size_t end = parts_.size(); end - begin > 1; begin += 2, ++end) {
      parts_.push_back(std::make_unique<adaptive::MergedRows>(*parts_[begin], *parts_[begin + 1]));
    }
    return *parts_.back();
  }

 private:
  std::vector<std::unique_ptr<adaptive::RowSource>> parts_;  ///< the files, followed by merges of two parts before them
  std::filesystem::path first_;
};

bool is_one_of(const std::filesystem::path& file, const std::vector<std::filesystem::path>& files) {
  return std::ranges::any_of(files, [&](const std::filesystem::path& other) {
    std::error_code error;
    return std::filesystem::equivalent(file, other, error) && !error;
  });
}

/// Writes `merged` as the whole output. If the output is an input too, the two are merged once more, because a session
/// may have saved into it meanwhile.
Result<adaptive::CacheSave> write(const CacheMergeSettings& settings, adaptive::RowSource& merged) {
  if (is_one_of(settings.output, settings.files)) {
    Result<adaptive::CacheUpdate> update = adaptive::merge_into_cache(settings.output, merged);
    if (!update) return update.error();
    if (update->refusal) return *update->refusal;
    return adaptive::CacheSave(*update);
  }
  if (std::optional<Error> error = check_cache_output(settings.output)) return *error;
  return adaptive::replace_cache(settings.output, merged);
}

/// Gives the same bytes for any order of the files, and prints the contents of the output. Exit status 1, with every
/// refused file named and nothing written, if one cannot be read or is of another model, or if `output` exists and is
/// no cache.
int run_cache_merge(const CacheMergeSettings& settings) {
  if (const auto error = check_output(settings.output)) {
    log_error(error->message());
    return 1;
  }
  ManyCaches caches;
  if (!caches.open(settings.files)) return 1;
  const Result<adaptive::CacheSave> written = write(settings, caches.joined());
  if (!written) {
    log_error(written.error().message());
    return 1;
  }
  log_removed(settings.output, written->removed);
  const adaptive::CacheContents& contents = written->contents;
  fmt::print("{}: {} files merged, {} pages, {} rows, {} of them converged, hash {}\n", settings.output.string(),
             settings.files.size(), contents.slices, contents.rows(), contents.converged_rows, contents.hash);
  return 0;
}

}  // namespace

Command add_cache_merge(CLI::App& cache) {
  const auto settings = std::make_shared<CacheMergeSettings>();
  CLI::App* merge = cache.add_subcommand("merge", "Join caches of one model; the same file for any order of them");
  merge->add_option("FILES", settings->files, "warm caches")->required()->type_name("A B ...");
  merge->add_option("-o,--output", settings->output, "the joined cache; may be one of them")
      ->required()
      ->type_name("OUT");
  return {merge, [settings] { return run_cache_merge(*settings); }};
}

}  // namespace tress::cli
