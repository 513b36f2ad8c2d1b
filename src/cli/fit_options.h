// The options of tress fit.
#pragma once

#include <CLI/CLI.hpp>

#include "cli/fit_command.h"

namespace tress::cli {

/// Adds the command; parsing fills `settings`, which must outlive it.
CLI::App* add_fit(CLI::App& app, FitSettings& settings);

}  // namespace tress::cli
