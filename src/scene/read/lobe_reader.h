// What a material says of single lobes and of their shapes.
#pragma once

#include <string>
#include <vector>

#include "scene/read/json_reader.h"
#include "tress/fiber/parameters.h"

namespace tress::scene {

/// The keys that read_lobes() reads, beside those of the material.
const std::vector<std::string>& lobe_keys();

/// longitudinal_shape, fresnel, gain and tint by lobe, glint. Naming GLINT splits it off TRT; where it is not
/// named it has the gain and tint of TRT, so that "glint": true changes layers only.
void read_lobes(const JsonReader& json, fiber::FiberParameters* fiber);

}  // namespace tress::scene
