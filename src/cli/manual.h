// Manual pages and shell completion, made of the parser that reads the command line: no option is missing in them.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace tress::cli {

/// A page in the man macros of the command, all commands below it included; `path`: "tress", "tress cache".
std::string manual_page(const CLI::App& command, const std::string& path);

/// A script for /usr/share/bash-completion/completions/tress.
std::string bash_completion(const CLI::App& tress);

/// A function for a folder in zsh's fpath, _tress.
std::string zsh_completion(const CLI::App& tress);

}  // namespace tress::cli
