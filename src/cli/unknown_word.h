// Words on the command line that no command and no option answers to.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace tress::cli {

std::vector<std::string> command_names(const CLI::App& app);

/// The first word that no command or option answers to, as a message that names the nearest; empty if there is none.
/// CLI11 would only say that it did not expect it.
std::string unknown_word(const CLI::App& root, const std::vector<std::string>& words);

}  // namespace tress::cli
