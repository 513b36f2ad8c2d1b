// The commands below `tress cache`. Info and verify are in cache_info_command.cpp.
#pragma once

#include "cli/commands.h"

namespace tress::cli {

Command add_cache_info(CLI::App& cache);
Command add_cache_verify(CLI::App& cache);
Command add_cache_merge(CLI::App& cache);
Command add_cache_prebake(CLI::App& cache);
Command add_cache_prune(CLI::App& cache);

}  // namespace tress::cli
