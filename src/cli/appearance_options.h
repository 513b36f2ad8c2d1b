// Options that say what a scene is beyond its file: the look of the hair, the light around it, where the camera stands.
#pragma once

#include <CLI/CLI.hpp>

#include "scene/read/load_scene.h"

namespace tress::cli {

/// Parsing fills `overrides`, which must outlive it.
void add_appearance(CLI::App* app, scene::Overrides& overrides);

}  // namespace tress::cli
