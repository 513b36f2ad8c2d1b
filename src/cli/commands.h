// The tress command: what its commands are, and render, report and farm, which have a file each; cache_commands.h,
// groom_commands.h and picture_commands.h have the others. Manual pages and shell completion are made from the parser
// too (manual.h), so that they lack no option.
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
Command add_report(CLI::App& tress);
/// farm itself comes last: its commands are tried before it.
std::vector<Command> add_farm(CLI::App& tress);

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

}  // namespace tress::cli
