// The options of tress cache and its commands.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "cli/cache_command.h"
#include "cli/cache_merge_command.h"
#include "cli/prebake_command.h"

namespace tress::cli {

/// What tress cache may be asked for; parsing fills the one that it was.
struct CacheOptions {
  CacheSettings look;
  CacheMergeSettings merge;
  PrebakeSettings prebake;
};

/// Adds the command; parsing fills `options` and `quiet`, which must outlive it.
CLI::App* add_cache(CLI::App& app, CacheOptions& options, bool& quiet);

/// Empty if what was parsed of `cache` makes sense; else what contradicts what: wrong usage.
std::string contradiction(const CLI::App& cache, const CacheOptions& options);

/// Runs the command of `cache` that was parsed. Exit status.
int run_cache(const CLI::App& cache, const CacheOptions& options);

}  // namespace tress::cli
