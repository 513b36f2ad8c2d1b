// tress cache prune: frees disk space by removing what render --warm-cache default has not used for longest.
#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "cli/commands.h"
#include "cli/console.h"
#include "cli/options.h"
#include "tress/adaptive/cache_folder.h"

namespace tress::cli {
namespace {

double megabytes(std::uint64_t bytes) { return double(bytes) / double(1 << 20); }

/// Returns exit status 1 if a file cannot be removed.
int run_prune(double limit) {
  const Result<std::filesystem::path> folder = adaptive::default_cache_folder();
  if (!folder) {
    log_error(folder.error().message());
    return 1;
  }
  const auto pruned = adaptive::CacheFolder(*folder).prune(std::uint64_t(limit * double(1 << 20)));
  if (!pruned) {
    log_error(pruned.error().message());
    return 1;
  }
  std::uint64_t bytes = 0;
  for (const adaptive::CacheFolder::File& file : pruned->removed) bytes += file.bytes;
  fmt::print("{}: removed {} files, {:.4g} MB, that were used longest ago; {} files, {:.4g} MB are left\n",
             folder->string(), pruned->removed.size(), megabytes(bytes), pruned->files_left,
             megabytes(pruned->bytes_left));
  return 0;
}

}  // namespace

Command add_cache_prune(CLI::App& cache) {
  const auto limit = std::make_shared<double>(1024);
  CLI::App* prune = cache.add_subcommand("prune", "Remove what render --warm-cache default has not used for longest");
  add_number(prune, "--limit", [limit](double x) { *limit = x; });
  return {prune, [limit] { return run_prune(*limit); }};
}

}  // namespace tress::cli
