// Checks before a render that need more than the command line.
#pragma once

#include <array>

#include "cli/render_settings.h"

namespace tress::cli {

/// X0, Y0, X1, Y1 as on the command line.
std::array<int, 4> edges_of(const image::Window& window);

/// Logs the errors: a crop or samples beyond the scene's, an unknown group of lights, a file that cannot be written.
/// Returns the exit status: 0 without an error, 2 for options, 1 for files.
int log_refusal(const RenderSettings& settings, const scene::Scene& scene);

}  // namespace tress::cli
