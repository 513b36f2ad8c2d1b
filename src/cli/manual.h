// Manual pages and completions of shells, made from the parser.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace tress::cli {

/// A manual page for the command and all commands below it, in man macros; `path`: "tress", "tress cache".
std::string manual_page(const CLI::App& command, const std::string& path);

/// A script for /usr/share/bash-completion/completions/tress.
std::string bash_completion(const CLI::App& tress);

/// A function for a folder in zsh's fpath, _tress.
std::string zsh_completion(const CLI::App& tress);

}  // namespace tress::cli
