// The options that change the shape of all fibers, and with it the slices of their rows.
#pragma once

#include <CLI/CLI.hpp>

#include "scene/read/load_scene.h"

namespace tress::cli {

/// --eccentricity and --roughness; parsing fills `overrides`, which must outlive it.
void add_fiber_shape(CLI::App* app, scene::Overrides& overrides);

}  // namespace tress::cli
