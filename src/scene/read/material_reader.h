// Reads the materials of a scene file.
#pragma once

#include <cstddef>

#include "scene/model/scene.h"
#include "scene/read/json_reader.h"

namespace tress::scene {

/// A material without any key. spectral: as Integrator::spectral.
Material usual_material(bool spectral);

/// Reads one element of /materials; `index` names it if it has no name.
Material read_material(const JsonReader& json, std::size_t index, bool spectral);

}  // namespace tress::scene
