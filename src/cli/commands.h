// The tress command and its commands: render, denoise, merge, report, diff, info, convert, farm, cache info, verify,
// merge, prebake and prune; each has its own file. Manual pages and shell completion are made from the parser too, so
// that they lack no option.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

namespace tress::cli {

/// A command that has been added to the parser, and the function to run once its options are parsed. Exit status: 0
/// success, 1 failure, 2 wrong usage, 130, 143 or 129 interrupted by a signal with everything saved.
struct Command {
  CLI::App* app;
  std::function<int()> run;
};

/// command: the words with which the program was started, for the header of the picture.
Command add_render(CLI::App& tress, const std::vector<std::string>& command);
Command add_diff(CLI::App& tress);
Command add_info(CLI::App& tress);
Command add_convert(CLI::App& tress);
Command add_denoise(CLI::App& tress);
Command add_merge(CLI::App& tress);
Command add_report(CLI::App& tress);
/// farm itself comes last: its commands are tried before it.
std::vector<Command> add_farm(CLI::App& tress);
Command add_cache_info(CLI::App& cache);
Command add_cache_verify(CLI::App& cache);
Command add_cache_merge(CLI::App& cache);
Command add_cache_prebake(CLI::App& cache);
Command add_cache_prune(CLI::App& cache);

/// Thrown by run() if options contradict each other, which the parser cannot detect. Exit status 2.
struct WrongUsage : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A program: its name, and its commands in addition to those of tress.
struct Program {
  std::string name = "tress";
  std::vector<Command (*)(CLI::App&)> commands;
};

/// Runs the whole program. Exit status as above.
int run(int argc, char** argv, const Program& program = {});

/// A manual page for the command and all commands below it, in man macros; `path`: "tress", "tress cache".
std::string manual_page(const CLI::App& command, const std::string& path);

/// A script for /usr/share/bash-completion/completions/tress.
std::string bash_completion(const CLI::App& tress);

/// A function for a folder in zsh's fpath, _tress.
std::string zsh_completion(const CLI::App& tress);

}  // namespace tress::cli
