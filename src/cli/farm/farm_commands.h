// What the commands of a farm share.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "farm/plan.h"
#include "farm/task_files.h"

namespace tress::cli {

/// Exit status of a task that failed and may be tried again, as EX_TEMPFAIL of sysexits.h.
inline constexpr int try_again_status = 75;

/// A farm and what is known of each of its tasks.
struct Farm {
  std::filesystem::path folder;
  farm::Plan plan;
  std::vector<farm::Task> tasks;

  farm::TaskFiles files(std::size_t task) const { return farm::task_files(folder, task, plan.frames.empty()); }
  /// The pictures that the task writes, and its part if it has one.
  std::vector<std::filesystem::path> outputs(std::size_t task) const;
  /// Whether it is done and what it has written is there.
  bool is_done(std::size_t task) const;
  /// Every picture that is to be there in the end.
  std::vector<std::filesystem::path> pictures() const;
  /// Whether the parts are merged, and the caches.
  bool is_merged() const;
};

/// Reads FOLDER/farm.json. The folder is made absolute.
Result<Farm> open_farm(const std::filesystem::path& folder);

/// What a program has printed on standard output, and its exit status; 127 if it cannot be started. Standard error
/// stays that of this process.
struct ProgramResult {
  int status = 127;
  std::string out;
};
ProgramResult run_program(const std::vector<std::string>& words);

/// Another command of tress in this process: {"merge", "a.part", ...}. Its exit status.
int run_command(std::vector<std::string> words);

/// A folder with farm.json, as the argument of a command.
CLI::Option* add_farm_folder(CLI::App* app, std::filesystem::path* folder);

CLI::App* add_farm_run(CLI::App& farm, std::function<int()>* run);
CLI::App* add_farm_merge(CLI::App& farm, std::function<int()>* run);
CLI::App* add_farm_status(CLI::App& farm, std::function<int()>* run);

}  // namespace tress::cli
