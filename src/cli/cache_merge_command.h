// tress cache merge: many warm caches into one.
#pragma once

#include <filesystem>
#include <vector>

namespace tress::cli {

struct CacheMergeSettings {
  std::vector<std::filesystem::path> files;  ///< at least one; any order, twice the same, with common ancestors
  std::filesystem::path output;              ///< may be one of `files`; otherwise a cache that is there is replaced
};

/// The same bytes for any order of the files. Says what the output holds. Exit status 1, with every refused file named
/// and nothing written, if one cannot be read or is of another model, or if `output` is there and is no cache.
int run_cache_merge(const CacheMergeSettings& settings);

}  // namespace tress::cli
