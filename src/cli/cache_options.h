// The options of tress cache and its commands.
#pragma once

#include <CLI/CLI.hpp>

#include "cli/cache_command.h"
#include "cli/cache_merge_command.h"

namespace tress::cli {

/// What tress cache may be asked for; parsing fills the one that it was.
struct CacheOptions {
  CacheSettings look;
  CacheMergeSettings merge;
};

/// Adds the command; parsing fills `options`, which must outlive it.
CLI::App* add_cache(CLI::App& app, CacheOptions& options);

/// Runs the command of `cache` that was parsed. Exit status.
int run_cache(const CLI::App& cache, const CacheOptions& options);

}  // namespace tress::cli
