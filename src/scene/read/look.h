// What options make of the materials and the light of a scene.
#pragma once

#include <optional>

#include "scene/read/load_scene.h"

namespace tress::scene {

/// Of an option that a caller gave a value out of the range of its parameter; the command line has checked them.
std::optional<Error> fault_of(const Overrides& overrides);

/// To a scene whose materials and light are as its file has them: their look, and the fibers of all strands.
std::optional<Error> apply_look(const Overrides& overrides, Scene* scene);

}  // namespace tress::scene
