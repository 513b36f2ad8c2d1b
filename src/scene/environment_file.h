// Environments from EXR files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "scene/environment.h"
#include "tress/adaptive/error.h"

namespace tress::scene {

/// A latitude-longitude map, top row up. R, G, B needed; at most 2^27 pixels. Negative values become 0 and a warning.
Result<Environment> load_environment(const std::filesystem::path& file, double rotate_rad, float scale,
                                     std::vector<std::string>* warnings);

}  // namespace tress::scene
