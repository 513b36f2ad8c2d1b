// Environments from EXR and HDR files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "scene/model/environment.h"
#include "tress/base/error.h"

namespace tress::scene {

/// A latitude-longitude map, top row up: OpenEXR with R, G, B, or RGBE (.hdr); which is told by its first bytes, not by
/// its name. At most 2^27 pixels, radiance at most 1e12. Negative values become 0, which is a warning; NaN and infinity
/// are errors. A map that is not twice as wide as high is a warning too.
Result<Environment> load_environment(const std::filesystem::path& file, double rotate_rad, float scale,
                                     std::vector<std::string>* warnings);

}  // namespace tress::scene
