// Checks before a render that need more than the command line.
#pragma once

#include <array>

#include "cli/render_settings.h"

namespace tress::cli {

/// X0, Y0, X1, Y1 as on the command line.
std::array<int, 4> edges_of(const image::Window& window);

/// Logs what is wrong: a crop or samples beyond the scene's, a group of lights that it does not have, a file that
/// cannot be written. Exit status: 0 if nothing is, 2 for options, 1 for files.
int log_refusal(const RenderSettings& settings, const scene::Scene& scene);

}  // namespace tress::cli
