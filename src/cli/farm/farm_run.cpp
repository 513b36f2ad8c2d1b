// tress farm run: runs one task, whoever starts it and however often.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iterator>
#include <memory>
#include <string>
#include <system_error>

#include "base/save_lock.h"
#include "cli/console.h"
#include "cli/farm/farm_commands.h"
#include "cli/options.h"
#include "tress/adaptive/cache.h"
#include "tress/base/replace_file.h"

namespace tress::cli {
namespace {

struct RunSettings {
  std::filesystem::path folder;
  std::size_t task = 0;
  std::string progress;  ///< "openjd" or empty
};

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

std::string host_name() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

/// The id of the job in Slurm; empty elsewhere.
std::string job_name() {
  const std::string array = environment("SLURM_ARRAY_JOB_ID");
  return array.empty() ? environment("SLURM_JOB_ID") : array + "_" + environment("SLURM_ARRAY_TASK_ID");
}

/// Copies the shared table as the task's starting table, unless the task already has one.
std::optional<Error> seed_cache(const std::filesystem::path& shared, const std::filesystem::path& own) {
  std::error_code error;
  if (std::filesystem::exists(own, error) || !std::filesystem::exists(shared, error)) return std::nullopt;
  if (const auto cache = adaptive::CacheFile::open(shared, ""); !cache) return cache.error();
  std::ifstream in(shared, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (!in) return Error{shared.string(), "", "a warm cache that can be read", "one that cannot"};
  return replace_file(own, bytes);
}

std::vector<std::string> render_words(const Farm& opened, const RunSettings& settings) {
  const farm::Plan& plan = opened.plan;
  const farm::Task& task = opened.tasks[settings.task];
  const farm::TaskFiles files = opened.files(settings.task);
  std::vector<std::string> words{"render",       plan.scene.string(),
                                 "-o",           (task.is_split() ? files.picture : plan.output).string(),
                                 "--checkpoint", files.checkpoint.string(),
                                 "--telemetry",  files.telemetry.string()};
  const auto add = [&](const char* name, const std::string& value) { words.insert(words.end(), {name, value}); };
  if (!task.frames.empty()) add("--frames", farm::frames_text(task.frames));
  if (plan.warm_cache) add("--warm-cache", (plan.frozen ? *plan.warm_cache : files.cache).string());
  if (plan.frozen) add("--cache-mode", "frozen");
  if (task.is_split()) {
    add("--samples-from", std::to_string(task.samples_from));
    add("--samples-to", std::to_string(task.samples_to));
    add("--part", files.part.string());
  }
  // Slurm limits the task to these cores, but its processes see the whole machine.
  const std::string cores = environment("SLURM_CPUS_ON_NODE");
  const bool has_threads =
      std::ranges::any_of(plan.options, [](const auto& word) { return word.starts_with("--threads"); });
  if (!cores.empty() && !has_threads) add("--threads", cores);
  if (!settings.progress.empty()) add("--progress", settings.progress);
  words.insert(words.end(), plan.options.begin(), plan.options.end());
  return words;
}

/// Merges what the first task has learned into the shared table, for all tasks.
int share_table(const Farm& opened, std::size_t task) {
  const farm::Plan& plan = opened.plan;
  if (task != 0 || !plan.calibrates || !plan.warm_cache || plan.frozen) return 0;
  std::error_code error;
  // A model without rows has no cache.
  if (!std::filesystem::exists(opened.files(task).cache, error)) return 0;
  std::vector<std::string> words{"cache", "merge", opened.files(task).cache.string()};
  if (std::filesystem::exists(*plan.warm_cache, error)) words.push_back(plan.warm_cache->string());
  words.insert(words.end(), {"-o", plan.warm_cache->string()});
  return run_command(words);
}

int render_task(const Farm& opened, const RunSettings& settings) {
  const farm::TaskFiles files = opened.files(settings.task);
  if (opened.plan.warm_cache && !opened.plan.frozen) {
    if (const auto error = seed_cache(*opened.plan.warm_cache, files.cache)) {
      log_error(error->message());
      return 1;
    }
  }
  const int status = run_command(render_words(opened, settings));
  return status == 0 ? share_table(opened, settings.task) : status;
}

bool save_state(const std::filesystem::path& file, const farm::TaskState& state) {
  const std::optional<Error> error = farm::write_state(file, state);
  if (error) log_error(error->message());
  return !error;
}

/// Must hold the lock of the task.
int run_locked(const Farm& opened, const RunSettings& settings) {
  const std::filesystem::path file = opened.files(settings.task).state;
  if (opened.is_done(settings.task)) {
    log_note(fmt::format("task {}: done before", settings.task));
    return 0;
  }
  farm::TaskState state = farm::read_state(file);
  if (state.phase == farm::Phase::done) state = {};
  if (state.attempts > opened.plan.retries) {
    state.phase = farm::Phase::failed;
    save_state(file, state);
    log_error(fmt::format("task {}: expected an end after {} attempts, found none; tress farm again starts anew",
                          settings.task, state.attempts));
    return 1;
  }
  state.phase = farm::Phase::running;
  state.host = host_name();
  state.job = job_name();
  ++state.attempts;
  std::error_code ignored;
  std::filesystem::remove(farm::merge_state_file(opened.folder), ignored);
  if (!save_state(file, state)) return 1;

  state.status = render_task(opened, settings);
  const bool by_signal = state.status > 128;
  const bool again = state.status == 1 && state.attempts <= opened.plan.retries;
  state.phase = state.status == 0 ? farm::Phase::done
                : by_signal       ? farm::Phase::interrupted
                : again           ? farm::Phase::waiting
                                  : farm::Phase::failed;
  if (by_signal) --state.attempts;
  if (!save_state(file, state)) return 1;
  return again ? try_again_status : state.status;
}

int run_task(const RunSettings& settings) {
  const Result<Farm> opened = open_farm(settings.folder);
  if (!opened) {
    log_error(opened.error().message());
    return 1;
  }
  if (settings.task >= opened->tasks.size()) {
    log_error(fmt::format("--task: expected one of the {} tasks, 0 to {}, found {}", opened->tasks.size(),
                          opened->tasks.size() - 1, settings.task));
    return 2;
  }
  std::error_code error;
  std::filesystem::current_path(opened->plan.directory, error);
  if (error) {
    log_error(Error{opened->plan.directory.string(), "", "the folder that the farm was asked for in", error.message()}
                  .message());
    return 1;
  }
  const std::filesystem::path state = opened->files(settings.task).state;
  if (farm::is_held(state)) log_note(fmt::format("task {}: waiting, another process works at it", settings.task));
  SaveLock lock;
  if (const auto refused = lock.acquire(state, state.string())) {
    log_error(refused->message());
    return 1;
  }
  return run_locked(*opened, settings);
}

}  // namespace

CLI::App* add_farm_run(CLI::App& farm, std::function<int()>* run) {
  const auto settings = std::make_shared<RunSettings>();
  RunSettings& s = *settings;
  CLI::App* command = farm.add_subcommand(
      "run", "One task: done once however often it is started; 75: it failed and may be tried again");
  add_farm_folder(command, &s.folder);
  add_whole(command, "--task", [&s](std::uint64_t n) { s.task = std::size_t(n); })->required();
  add_choice(
      command, "--progress", {"openjd"}, [&s](const std::string& name) { s.progress = name; },
      "lines on standard output that Open Job Description reads");
  add_quiet(command);
  *run = [settings] { return run_task(*settings); };
  return command;
}

}  // namespace tress::cli
