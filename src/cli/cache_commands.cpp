// tress cache prebake: learns the whole table of a scene beforehand, as the paper does.
#include "cli/cache_commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "cli/bake_table.h"
#include "cli/console.h"
#include "cli/model_choice.h"
#include "cli/options.h"
#include "cli/output_files.h"
#include "cli/process.h"
#include "cli/telemetry_lines.h"
#include "models/catalog.h"
#include "models/default_model.h"
#include "scene/read/load_scene.h"
#include "tress/adaptive/cache.h"
#include "tress/adaptive/cache_folder.h"
#include "tress/adaptive/options.h"
#include "tress/adaptive/service.h"

namespace tress::cli {
namespace {

/// Every value is in range, because the command line has been checked.
struct PrebakeSettings {
  std::filesystem::path scene, output;
  scene::Overrides overrides;
  std::string model{fiber::usual_model};  ///< one of fiber::models(), with rows
  bool model_of_scene = false;            ///< without --model: use that of the scene's materials
  std::vector<fiber::AskedOption> asked;  ///< options that the model must support
  adaptive::Options table;
  std::optional<int> threads;
  std::optional<std::filesystem::path> telemetry;
};

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// Prints a line now and then; on a terminal it redraws one line.
class BakeNotes {
 public:
  void show(const BakeProgress& progress) {
    const std::string text =
        fmt::format("{:3.0f} %, pass {}, {} of {} rows converged{}",
                    100.0 * double(progress.decided()) / double(progress.nodes), progress.passes, progress.converged,
                    progress.nodes, progress.refused > 0 ? fmt::format(", {} refused", progress.refused) : "");
    if (console_is_terminal()) return draw_bar(text);
    if (seconds_since(last_) < 10) return;
    last_ = Clock::now();
    log_note(text);
  }

 private:
  Clock::time_point last_ = Clock::now();
};

class PrebakeJob {
 public:
  PrebakeJob(const PrebakeSettings& settings, const scene::Scene& scene, TelemetryLines& telemetry, int threads)
      : settings_(settings), info_(*fiber::find_model(settings.model)), telemetry_(telemetry), threads_(threads) {
    learned_ = fiber::make_service(info_, baking(settings.table));
    service_ = learned_.service.get();
    fiber::ModelSettings model;
    model.service = service_;
    const std::unique_ptr<fiber::FiberModel> slices = info_.make(model);
    for (const fiber::FiberParameters& fiber : scene.fibers) (void)slices->add_fiber(fiber);
    write_header(scene);
  }

  /// Must run inside the arena.
  int run() {
    const InterruptGuard interrupt;
    const Clock::time_point start = Clock::now();
    log_note(fmt::format("{} pages, learner {}, epsilon {}", service_->slice_count(),
                         info_.learner_name(settings_.table), info_.epsilon(settings_.table)));
    BakeNotes notes;
    const BakeProgress baked = bake_table(*service_, [&](const BakeProgress& progress) {
      notes.show(progress);
      write_pass(progress);
      return !interrupt.requested();
    });
    draw_bar("");
    const int status = save(baked, interrupt.exit_status());
    write_summary(baked, status, seconds_since(start));
    return telemetry_.failed() ? 1 : status;
  }

 private:
  int save(const BakeProgress& baked, int signal_status) {
    const Result<adaptive::CacheSave> saved = adaptive::replace_cache(settings_.output, *service_->rows());
    hash_ = saved ? saved->contents.hash : adaptive::cache_hash(*service_->rows());
    if (!saved) {
      log_error(saved.error().message());
      return 1;
    }
    log_removed(settings_.output, saved->removed);
    const std::uint64_t left = baked.nodes - baked.decided();
    if (baked.refused > 0) {
      log_warning(fmt::format("{} of {} rows did not converge in {} tests; renders answer them by g at the node",
                              baked.refused, baked.nodes, settings_.table.tests_before_refusal));
    }
    if (left > 0) {
      log_warning(fmt::format("{} of {} rows were not learned: {}", left, baked.nodes,
                              signal_status != 0      ? "interrupted"
                              : baked.last.at_ceiling ? "the table is full, see --table-memory"
                                                      : "they were still open after 4096 passes"));
    }
    fmt::print("{}: {} pages, {} rows, {} of them converged, {} refused, hash {}\n", settings_.output.string(),
               service_->slice_count(), baked.nodes - left, baked.converged, baked.refused, hash_);
    return signal_status;
  }

  void write_header(const scene::Scene& scene) {
    telemetry_.write([&](adaptive::TelemetryWriter& writer) {
      return writer.header({{"scene", json_text(scene.source)},
                            {"model", json_text(settings_.model)},
                            {"learner", json_text(info_.learner_name(settings_.table))},
                            {"epsilon", json_text(info_.epsilon(settings_.table))},
                            {"seed", json_text(settings_.table.seed)},
                            {"threads", json_text(threads_)},
                            {"pages", json_text(service_->slice_count())},
                            {"memory_limit", json_text(settings_.table.memory_bytes)}});
    });
  }

  void write_pass(const BakeProgress& progress) {
    telemetry_.write([&](adaptive::TelemetryWriter& writer) {
      return writer.pass(progress.last, {{"pass", json_text(progress.passes - 1)},
                                         {"pixels", "0"},
                                         {"samples", "0"},
                                         {"seconds", json_text(progress.seconds)}});
    });
  }

  void write_summary(const BakeProgress& baked, int status, double seconds) {
    telemetry_.write([&](adaptive::TelemetryWriter& writer) {
      return writer.summary({{"status", json_text(status == 0   ? "done"
                                                  : status == 1 ? "failed"
                                                                : "interrupted")},
                             {"passes", json_text(baked.passes)},
                             {"seconds", json_text(seconds)},
                             {"nodes", json_text(baked.nodes)},
                             {"rows_converged", json_text(baked.converged)},
                             {"rows_refused", json_text(baked.refused)},
                             {"g_evaluations", json_text(baked.g_evaluations)},
                             {"cache_hash", json_text(hash_)},
                             {"cache", json_text(settings_.output.string())}});
    });
  }

  const PrebakeSettings& settings_;
  const fiber::ModelInfo& info_;
  TelemetryLines& telemetry_;
  int threads_;
  fiber::ModelService learned_;
  adaptive::Service* service_ = nullptr;  ///< the service in learned_
  std::string hash_;
};

/// A message about options that contradict each other (wrong usage); empty if there are none.
std::string contradiction(const PrebakeSettings& settings) {
  if (!settings.model_of_scene) {
    if (const std::string message = refused_option(settings.asked, settings.model, true); !message.empty())
      return message;
  }
  if (settings.telemetry) {
    std::error_code a, b;
    if (std::filesystem::weakly_canonical(*settings.telemetry, a) ==
        std::filesystem::weakly_canonical(settings.output, b)) {
      return fmt::format("{}: expected different files for cache and telemetry", settings.output.string());
    }
  }
  return {};
}

/// Learns every row of every slice of the scene's fibers and saves them as a warm cache, replacing an existing one.
/// Rows that did not converge are counted on stderr and saved as open. Exit status: 0, also with such rows; 1 with
/// nothing written; 2 if the scene's model has no rows or does not support the options; 130, 143 or 129 after a signal,
/// with what was learned by then.
int run_prebake(PrebakeSettings settings) {
  if (const std::optional<Error> error = check_cache_output(settings.output)) {
    log_error(error->message());
    return 1;
  }
  const Result<scene::Scene> scene = scene::load_scene(settings.scene, settings.overrides);
  if (!scene) {
    log_error(scene.error().message());
    return 1;
  }
  for (const std::string& text : scene->warnings) log_warning(text);
  if (settings.model_of_scene) settings.model = model_of_scene(*scene);
  if (const std::string message = refused_option(settings.asked, settings.model, !settings.model_of_scene);
      !message.empty()) {
    log_error(message);
    return 2;
  }
  log_model_lacks(*scene, settings.model);
  Result<TelemetryLines> telemetry = TelemetryLines::open(settings.telemetry);
  if (!telemetry) {
    log_error(telemetry.error().message());
    return 1;
  }
  return run_threaded(settings.threads,
                      [&](int threads) { return PrebakeJob(settings, *scene, *telemetry, threads).run(); });
}

}  // namespace

Command add_cache_prebake(CLI::App& cache) {
  const auto settings = std::make_shared<PrebakeSettings>();
  PrebakeSettings& s = *settings;
  CLI::App* prebake = cache.add_subcommand("prebake", "Learn the whole table of a scene without rendering");
  prebake
      ->add_option_function<std::string>(
          "SCENE", [&s](const std::string& file) { s.scene = file; }, "scene JSON, or strands of any format")
      ->required();
  add_file(
      prebake, "-o,--output", [&s](const std::string& file) { s.output = file; },
      "warm cache; one that is there is replaced")
      ->required();
  std::vector<std::string> models;
  for (const fiber::ModelInfo& model : fiber::models()) models.emplace_back(model.name);
  add_choice(
      prebake, "--model", models, [&s](const std::string& name) { s.model = name; },
      "fiber model, one that has rows; default: as of render");
  add_learner(prebake, s.table);
  add_fiber_shape(prebake, s.overrides);
  add_threads(prebake, s.threads);
  add_whole(prebake, "--seed", [&s](std::uint64_t seed) { s.table.seed = seed; });
  add_file(prebake, "--telemetry", [&s](const std::string& file) { s.telemetry = file; }, "convergence as JSON Lines");
  add_quiet(prebake);
  return {prebake, [prebake, settings] {
            settings->model_of_scene = prebake->count("--model") == 0;
            settings->asked = model_options(*prebake, fiber::Estimator::fitted);
            settings->asked.insert(settings->asked.begin(), {"cache prebake", fiber::Asks::rows});
            if (const std::string message = contradiction(*settings); !message.empty()) throw WrongUsage(message);
            return run_prebake(*settings);
          }};
}

// tress cache merge: merges many warm caches into one.
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

// tress cache prune: frees disk space by removing what render --warm-cache default has not used for longest.
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
