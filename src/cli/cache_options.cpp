#include "cli/cache_options.h"

namespace tress::cli {

CLI::App* add_cache(CLI::App& app, CacheOptions& options) {
  CLI::App* cache = app.add_subcommand("cache", "Look into warm caches, and merge them");
  cache->require_subcommand(1);
  CLI::App* info = cache->add_subcommand("info", "Print model, format, pages and hash");
  CLI::App* verify = cache->add_subcommand("verify", "Exit 0 if the file is whole, 1 if it is refused");
  for (CLI::App* command : {info, verify}) {
    command->add_option("FILE", options.look.file, "warm cache")->required()->type_name("FILE");
    command->add_flag("--json", options.look.json, "print JSON");
  }
  CLI::App* merge = cache->add_subcommand("merge", "Join caches of one model; the same file for any order of them");
  merge->add_option("FILES", options.merge.files, "warm caches")->required()->type_name("A B ...");
  merge->add_option("-o,--output", options.merge.output, "the joined cache; may be one of them")
      ->required()
      ->type_name("OUT");
  return cache;
}

int run_cache(const CLI::App& cache, const CacheOptions& options) {
  if (cache.got_subcommand("merge")) return run_cache_merge(options.merge);
  return cache.got_subcommand("info") ? run_cache_info(options.look) : run_cache_verify(options.look);
}

}  // namespace tress::cli
