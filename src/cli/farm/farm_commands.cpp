#include "cli/farm/farm_commands.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <memory>
#include <utility>

#include "base/descriptor.h"
#include "cli/commands.h"
#include "cli/frame_list.h"

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

}  // namespace tress::cli
