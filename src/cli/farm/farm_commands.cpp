#include "cli/farm/farm_commands.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <utility>

#include "base/descriptor.h"
#include "base/save_lock.h"
#include "cli/commands.h"
#include "cli/console.h"
#include "cli/frame_list.h"
#include "cli/options.h"

namespace tress::cli {

std::vector<std::filesystem::path> Farm::outputs(std::size_t task) const {
  const farm::Task& what = tasks[task];
  std::vector<std::filesystem::path> patterns{plan.output};
  if (what.is_split()) patterns = {files(task).picture, files(task).part};
  std::vector<std::filesystem::path> all;
  for (const std::filesystem::path& pattern : patterns) {
    if (what.frames.empty()) all.push_back(pattern);
    for (const int frame : what.frames) all.push_back(of_frame(pattern, frame));
  }
  return all;
}

bool Farm::is_done(std::size_t task) const {
  if (farm::read_state(files(task).state).phase != farm::Phase::done) return false;
  std::error_code error;
  return std::ranges::all_of(outputs(task), [&](const auto& file) { return std::filesystem::exists(file, error); });
}

std::vector<std::filesystem::path> Farm::pictures() const {
  if (plan.frames.empty()) return {plan.output};
  std::vector<std::filesystem::path> all;
  for (const int frame : plan.frames) all.push_back(of_frame(plan.output, frame));
  return all;
}

bool Farm::is_merged() const {
  std::error_code error;
  return farm::read_state(farm::merge_state_file(folder)).phase == farm::Phase::done &&
         std::ranges::all_of(pictures(), [&](const auto& file) { return std::filesystem::exists(file, error); });
}

Result<Farm> open_farm(const std::filesystem::path& folder) {
  Result<farm::Plan> plan = farm::read_plan(folder);
  if (!plan) return plan.error();
  std::error_code error;
  Farm opened{std::filesystem::weakly_canonical(folder, error), std::move(*plan), {}};
  if (error) return Error{folder.string(), "", "a folder", error.message()};
  opened.tasks = farm::tasks_of(opened.plan);
  return opened;
}

ProgramResult run_program(const std::vector<std::string>& words) {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) return {};
  const Descriptor reading(ends[0]);
  Descriptor writing(ends[1]);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, writing.number(), 1);
  std::vector<std::string> copies = words;
  std::vector<char*> arguments;
  for (std::string& word : copies) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_t child = -1;
  const int failed = ::posix_spawnp(&child, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) return {};
  writing.close();
  ProgramResult result;
  std::array<char, 4096> buffer{};
  for (ssize_t got = 0; (got = ::read(reading.number(), buffer.data(), buffer.size())) != 0;) {
    if (got > 0) result.out.append(buffer.data(), std::size_t(got));
    if (got < 0 && errno != EINTR) break;
  }
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  result.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return result;
}

int run_command(std::vector<std::string> words) {
  words.insert(words.begin(), "tress");
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  return run(int(words.size()), arguments.data());
}

CLI::Option* add_farm_folder(CLI::App* app, std::filesystem::path* folder) {
  return app->add_option("FOLDER", *folder, "folder of a farm, as tress farm has printed it")
      ->required()
      ->type_name("FOLDER");
}

// tress farm status: prints the state of every task of a farm.
namespace {

struct StatusSettings {
  std::filesystem::path folder;
  bool json = false;
};

struct TaskStatus {
  std::string state;  ///< from phase_name(), or "killed", "lost"
  farm::TaskState recorded;
  std::size_t pictures = 0;  ///< finished
};

/// Counts the finished pictures of the task. A picture is saved with each checkpoint too, and the checkpoint is removed
/// when the picture is finished.
std::size_t finished_pictures(const Farm& opened, std::size_t task) {
  const farm::TaskFiles files = opened.files(task);
  const farm::Task& what = opened.tasks[task];
  const std::filesystem::path picture = what.is_split() ? files.picture : opened.plan.output;
  const auto is_there = [](const std::filesystem::path& file) {
    std::error_code error;
    return std::filesystem::exists(file, error);
  };
  if (what.frames.empty()) return is_there(picture) && !is_there(files.checkpoint) ? 1 : 0;
  return std::size_t(std::ranges::count_if(what.frames, [&](int frame) {
    return is_there(of_frame(picture, frame)) && !is_there(of_frame(files.checkpoint, frame));
  }));
}

TaskStatus status_of(const Farm& opened, std::size_t task) {
  const std::filesystem::path file = opened.files(task).state;
  TaskStatus status;
  status.recorded = farm::read_state(file);
  status.state = farm::phase_name(status.recorded.phase);
  if (status.recorded.phase == farm::Phase::running && !farm::is_held(file)) status.state = "killed";
  if (status.recorded.phase == farm::Phase::done && !opened.is_done(task)) status.state = "lost";
  status.pictures = finished_pictures(opened, task);
  return status;
}

std::string frames_of(const farm::Task& task) {
  std::string text = task.frames.empty() ? "still" : farm::frames_text(task.frames);
  if (task.is_split()) text += fmt::format(" samples {}-{}", task.samples_from, task.samples_to - 1);
  return text;
}

nlohmann::ordered_json to_json(const Farm& opened, const std::vector<TaskStatus>& all, std::size_t done) {
  nlohmann::ordered_json tasks = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < all.size(); ++i) {
    tasks.push_back({{"task", i},
                     {"state", all[i].state},
                     {"frames", frames_of(opened.tasks[i])},
                     {"pictures", all[i].pictures},
                     {"attempts", all[i].recorded.attempts},
                     {"status", all[i].recorded.status},
                     {"host", all[i].recorded.host},
                     {"job", all[i].recorded.job}});
  }
  return {{"folder", opened.folder.string()}, {"done", done}, {"merged", opened.is_merged()}, {"tasks", tasks}};
}

/// Exit status 0: everything is rendered and merged; 3: not yet; 1: no farm, or a task has failed for good.
int print_status(const StatusSettings& settings) {
  const Result<Farm> opened = open_farm(settings.folder);
  if (!opened) {
    log_error(opened.error().message());
    return 1;
  }
  std::vector<TaskStatus> all;
  for (std::size_t task = 0; task < opened->tasks.size(); ++task) all.push_back(status_of(*opened, task));
  const auto count = [&](const char* state) {
    return std::size_t(std::ranges::count_if(all, [&](const TaskStatus& task) { return task.state == state; }));
  };
  const bool merged = opened->is_merged();
  const int status = count("failed") > 0 ? 1 : merged ? 0 : 3;
  if (settings.json) {
    fmt::print("{}\n",
               to_json(*opened, all, count("done")).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
    return status;
  }
  std::string counts;
  for (const char* state : {"done", "running", "waiting", "interrupted", "killed", "failed", "lost"}) {
    if (const std::size_t n = count(state); n > 0)
      counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", n, state);
  }
  fmt::print("farm   {}\nscene  {}\ntasks  {}: {}\nmerge  {}\n", opened->folder.string(), opened->plan.scene.string(),
             all.size(), counts, merged ? "done" : "waiting");
  fmt::print("  {:>4} {:11} {:>8} {:>8}  {:16} {:14} {}\n", "task", "state", "attempts", "pictures", "frames", "job",
             "host");
  for (std::size_t i = 0; i < all.size(); ++i) {
    fmt::print("  {:4} {:11} {:8} {:8}  {:16} {:14} {}\n", i, all[i].state, all[i].recorded.attempts, all[i].pictures,
               frames_of(opened->tasks[i]), all[i].recorded.job, all[i].recorded.host);
  }
  return status;
}

}  // namespace

CLI::App* add_farm_status(CLI::App& farm, std::function<int()>* run) {
  const auto settings = std::make_shared<StatusSettings>();
  CLI::App* command =
      farm.add_subcommand("status", "Where every task is; exit 0: all done and merged, 3: not yet, 1: one has failed");
  add_farm_folder(command, &settings->folder);
  command->add_flag("--json", settings->json, "print JSON");
  *run = [settings] { return print_status(*settings); };
  return command;
}

// tress farm merge: merges pictures and table of a farm whose tasks are all done.
namespace {

/// Logs the tasks that are not done; returns whether all are.
bool is_whole(const Farm& opened) {
  std::vector<std::size_t> missing;
  for (std::size_t task = 0; task < opened.tasks.size(); ++task) {
    if (!opened.is_done(task)) missing.push_back(task);
  }
  if (missing.empty()) return true;
  log_error(Error{opened.folder.string(), "", fmt::format("{} tasks that are done", opened.tasks.size()),
                  fmt::format("{} that {} not: {}; nothing is merged", missing.size(),
                              missing.size() == 1 ? "is" : "are", farm::ranges_text(missing))}
                .message());
  return false;
}

/// The --precision of the renders, which a merge has too.
std::vector<std::string> precision_of(const std::vector<std::string>& options) {
  for (std::size_t i = 0; i < options.size(); ++i) {
    if (options[i] == "--precision" && i + 1 < options.size()) return {options[i], options[i + 1]};
    if (options[i].starts_with("--precision=")) return {options[i]};
  }
  return {};
}

/// Merges the parts of each picture, which are consecutive tasks.
int merge_pictures(const Farm& opened) {
  const farm::Plan& plan = opened.plan;
  if (plan.split == 0) return 0;
  const std::vector<std::filesystem::path> pictures = opened.pictures();
  for (std::size_t picture = 0; picture < pictures.size(); ++picture) {
    std::vector<std::string> words{"merge"};
    for (std::size_t part = 0; part < std::size_t(plan.split); ++part) {
      const std::size_t task = picture * std::size_t(plan.split) + part;
      words.push_back(opened.outputs(task).back().string());
    }
    words.insert(words.end(), {"-o", pictures[picture].string()});
    for (const std::string& word : precision_of(plan.options)) words.push_back(word);
    if (const int status = run_command(words); status != 0) return status;
  }
  return 0;
}

int merge_caches(const Farm& opened) {
  const farm::Plan& plan = opened.plan;
  if (!plan.warm_cache || plan.frozen) return 0;
  std::vector<std::string> words{"cache", "merge"};
  std::error_code error;
  for (std::size_t task = 0; task < opened.tasks.size(); ++task) {
    const std::filesystem::path cache = opened.files(task).cache;
    // A task of a model without rows has no cache.
    if (std::filesystem::exists(cache, error)) words.push_back(cache.string());
  }
  if (words.size() == 2) return 0;
  if (std::filesystem::exists(*plan.warm_cache, error)) words.push_back(plan.warm_cache->string());
  words.insert(words.end(), {"-o", plan.warm_cache->string()});
  return run_command(words);
}

int merge_farm(const std::filesystem::path& folder) {
  const Result<Farm> opened = open_farm(folder);
  if (!opened) {
    log_error(opened.error().message());
    return 1;
  }
  const std::filesystem::path file = farm::merge_state_file(opened->folder);
  SaveLock lock;
  if (const auto refused = lock.acquire(file, file.string())) {
    log_error(refused->message());
    return 1;
  }
  if (!is_whole(*opened)) return 1;
  if (opened->is_merged()) {
    log_note(fmt::format("{}: merged before", opened->folder.string()));
    return 0;
  }
  farm::TaskState state;
  state.attempts = farm::read_state(file).attempts + 1;
  state.status = merge_pictures(*opened);
  if (state.status == 0) state.status = merge_caches(*opened);
  state.phase = state.status == 0 ? farm::Phase::done : farm::Phase::failed;
  if (const auto error = farm::write_state(file, state)) {
    log_error(error->message());
    return 1;
  }
  if (state.status == 0)
    log_note(fmt::format("{}: {} pictures of {} tasks", opened->folder.string(), opened->pictures().size(),
                         opened->tasks.size()));
  return state.status;
}

}  // namespace

CLI::App* add_farm_merge(CLI::App& farm, std::function<int()>* run) {
  const auto folder = std::make_shared<std::filesystem::path>();
  CLI::App* command =
      farm.add_subcommand("merge", "Parts to pictures and caches to one, once all tasks are done; nothing before");
  add_farm_folder(command, folder.get());
  add_quiet(command);
  *run = [folder] { return merge_farm(*folder); };
  return command;
}

}  // namespace tress::cli
