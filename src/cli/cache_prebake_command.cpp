// tress cache prebake: learns the whole table of a scene beforehand, as the paper does.
#include <fmt/format.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <system_error>

#include "cli/bake_table.h"
#include "cli/commands.h"
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
  log_lost_parts(*scene, settings.model);
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

}  // namespace tress::cli
