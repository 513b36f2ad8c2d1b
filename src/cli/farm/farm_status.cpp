// tress farm status: prints the state of every task of a farm.
#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>

#include "cli/console.h"
#include "cli/farm/farm_commands.h"
#include "cli/frame_list.h"

namespace tress::cli {
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

}  // namespace tress::cli
