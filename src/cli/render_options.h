// The options of tress render.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "cli/render_command.h"

namespace tress::cli {

/// Adds the command; parsing fills `settings` and `quiet`, which must outlive it.
CLI::App* add_render(CLI::App& app, RenderSettings& settings, bool& quiet);

/// What the parser cannot see: options that contradict each other, and files that would overwrite each other. A
/// message, empty if there is nothing.
std::string contradiction(const CLI::App& render, const RenderSettings& settings);

}  // namespace tress::cli
