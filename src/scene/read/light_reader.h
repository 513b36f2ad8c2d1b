// Reads the lights of a scene file, and what its environment has in common with them.
#pragma once

#include <string>

#include "scene/model/scene.h"
#include "scene/read/assembly.h"
#include "scene/read/json_reader.h"

namespace tress::scene {

struct LightDescription {
  Light light;  ///< before the transform
  ObjectPath path = {};
};

/// The Light::group of a light or an environment; empty without one.
std::string read_light_group(const JsonReader& json);

/// The Light::links of a light or an environment.
LightLinks read_links(const JsonReader& json);

/// Reads one element of /lights.
LightDescription read_light(const JsonReader& json);

/// Reads /lights/N/distant, or the sun of a sky.
Light read_distant_light(const JsonReader& json);

}  // namespace tress::scene
