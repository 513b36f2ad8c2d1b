// The tress command and its commands: render, denoise, merge, report, diff, info, convert, farm, cache info, verify,
// merge, prebake and prune; each has its file. And the parser in other forms: manual pages and shell
// completion, so that no option is missing in them.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

namespace tress::cli {

/// A command that has been added to the parser, and what it does once its options are parsed: exit status 0 done, 1
/// could not, 2 wrong usage, 130, 143 or 129 interrupted by a signal with everything saved.
struct Command {
  CLI::App* app;
  std::function<int()> run;
};

/// command: the words that the program was started with, for the header of the picture.
Command add_render(CLI::App& tress, const std::vector<std::string>& command);
Command add_diff(CLI::App& tress);
Command add_info(CLI::App& tress);
Command add_convert(CLI::App& tress);
Command add_denoise(CLI::App& tress);
Command add_merge(CLI::App& tress);
Command add_report(CLI::App& tress);
/// farm itself last: its commands are asked before it.
std::vector<Command> add_farm(CLI::App& tress);
Command add_cache_info(CLI::App& cache);
Command add_cache_verify(CLI::App& cache);
Command add_cache_merge(CLI::App& cache);
Command add_cache_prebake(CLI::App& cache);
Command add_cache_prune(CLI::App& cache);

/// What the parser cannot see, thrown by run(): options that contradict each other. Exit status 2.
struct WrongUsage : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A program: its name, and the commands that it has beside those of tress.
struct Program {
  std::string name = "tress";
  std::vector<Command (*)(CLI::App&)> commands;
};

/// The whole program. Exit status as above.
int run(int argc, char** argv, const Program& program = {});

/// A page in the man macros of the command, all commands below it included; `path`: "tress", "tress cache".
std::string manual_page(const CLI::App& command, const std::string& path);

/// A script for /usr/share/bash-completion/completions/tress.
std::string bash_completion(const CLI::App& tress);

/// A function for a folder in zsh's fpath, _tress.
std::string zsh_completion(const CLI::App& tress);

}  // namespace tress::cli
