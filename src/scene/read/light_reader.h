// Lights of a scene file.
#pragma once

#include "scene/model/scene.h"
#include "scene/read/json_reader.h"

namespace tress::scene {

/// One element of /lights.
Light read_light(const JsonReader& json);

/// What /lights/N/distant and the sun of a sky are.
Light read_distant_light(const JsonReader& json);

}  // namespace tress::scene
