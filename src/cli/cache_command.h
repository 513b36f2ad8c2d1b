// tress cache: what is in a warm cache, and whether it is whole.
#pragma once

#include <filesystem>

namespace tress::cli {

struct CacheSettings {
  std::filesystem::path file;
  bool json = false;
};

/// Prints model, format, slices and hash. Exit status 1 if the file is refused.
int run_cache_info(const CacheSettings& settings);
/// Exit status 0 if every byte of the file is as it was written, 1 with the reason if not.
int run_cache_verify(const CacheSettings& settings);

}  // namespace tress::cli
