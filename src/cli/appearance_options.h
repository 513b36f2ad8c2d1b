// Options for the look of a scene beyond its file: the hair, the light around it, the place of the camera.
#pragma once

#include <CLI/CLI.hpp>

#include "scene/read/load_scene.h"

namespace tress::cli {

/// Parsing fills `overrides`, which must outlive it.
void add_appearance(CLI::App* app, scene::Overrides& overrides);

}  // namespace tress::cli
