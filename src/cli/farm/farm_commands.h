// The common part of the commands of a farm.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "farm/plan.h"
#include "farm/task_files.h"

namespace tress::cli {

/// Exit status of a task that failed and may be tried again: EX_TEMPFAIL of sysexits.h.
inline constexpr int try_again_status = 75;

/// A farm and the state of its tasks.
struct Farm {
  std::filesystem::path folder;
  farm::Plan plan;
  std::vector<farm::Task> tasks;

  farm::TaskFiles files(std::size_t task) const { return farm::task_files(folder, task, plan.frames.empty()); }
  /// The pictures that the task writes, and its part if it has one.
  std::vector<std::filesystem::path> outputs(std::size_t task) const;
  /// Whether it is done and its outputs exist.
  bool is_done(std::size_t task) const;
  /// All pictures of the finished farm.
  std::vector<std::filesystem::path> pictures() const;
  /// Whether the parts and the caches are merged.
  bool is_merged() const;
};

/// Reads FOLDER/farm.json, and makes the folder absolute.
Result<Farm> open_farm(const std::filesystem::path& folder);

/// The standard output of a program and its exit status; 127 if it cannot be started. Its standard error is that of
/// this process.
struct ProgramResult {
  int status = 127;
  std::string out;
};
ProgramResult run_program(const std::vector<std::string>& words);

/// Runs another command of tress in this process, such as {"merge", "a.part", ...}. Returns its exit status.
int run_command(std::vector<std::string> words);

/// Adds an argument of a command: a folder with farm.json.
CLI::Option* add_farm_folder(CLI::App* app, std::filesystem::path* folder);

CLI::App* add_farm_run(CLI::App& farm, std::function<int()>* run);
CLI::App* add_farm_merge(CLI::App& farm, std::function<int()>* run);
CLI::App* add_farm_status(CLI::App& farm, std::function<int()>* run);

}  // namespace tress::cli
