#include "cli/cache_options.h"

#include <cstdint>
#include <string>
#include <vector>

#include "cli/fiber_options.h"
#include "cli/learner_options.h"
#include "cli/option_types.h"
#include "references/registry.h"

namespace tress::cli {

namespace {

void add_prebake(CLI::App* cache, PrebakeSettings& s, bool& quiet) {
  CLI::App* prebake = cache->add_subcommand("prebake", "Learn the whole table of a scene without rendering");
  prebake
      ->add_option_function<std::string>(
          "SCENE", [&s](const std::string& file) { s.scene = file; }, "scene JSON or .hair file")
      ->required();
  prebake
      ->add_option_function<std::string>(
          "-o,--output", [&s](const std::string& file) { s.output = file; },
          "warm cache; one that is there is replaced")
      ->required()
      ->type_name("FILE");
  std::vector<std::string> models;
  for (const fiber::ModelInfo& model : references::models()) models.emplace_back(model.name);
  add_choice(
      prebake, "--model", models, [&s](const std::string& name) { s.model = name; }, "fiber model, one that has rows");
  add_learner(prebake, s.table);
  add_fiber_shape(prebake, s.overrides);
  add_integer(prebake, "--threads", 1, 1024, [&s](int n) { s.threads = n; }, "default: one per hardware thread");
  add_unsigned(
      prebake, "--seed", [&s](std::uint64_t seed) { s.table.seed = seed; },
      "same seed, same table, for any number of threads");
  prebake
      ->add_option_function<std::string>(
          "--telemetry", [&s](const std::string& file) { s.telemetry = file; }, "convergence as JSON Lines")
      ->type_name("FILE");
  prebake->add_flag("--quiet", quiet, "no progress and no notes");
}

}  // namespace

CLI::App* add_cache(CLI::App& app, CacheOptions& options, bool& quiet) {
  CLI::App* cache = app.add_subcommand("cache", "Look into warm caches, merge them, or make one beforehand");
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
  add_prebake(cache, options.prebake, quiet);
  return cache;
}

std::string contradiction(const CLI::App& cache, const CacheOptions& options) {
  return cache.got_subcommand("prebake") ? contradiction(options.prebake) : "";
}

int run_cache(const CLI::App& cache, const CacheOptions& options) {
  if (cache.got_subcommand("prebake")) return run_prebake(options.prebake);
  if (cache.got_subcommand("merge")) return run_cache_merge(options.merge);
  return cache.got_subcommand("info") ? run_cache_info(options.look) : run_cache_verify(options.look);
}

}  // namespace tress::cli
