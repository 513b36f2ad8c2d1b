// Materials of a scene file.
#pragma once

#include "scene/model/scene.h"
#include "scene/read/json_reader.h"

namespace tress::scene {

/// One element of /materials; `index` names it where it has no name.
Material read_material(const JsonReader& json, std::size_t index);

}  // namespace tress::scene
