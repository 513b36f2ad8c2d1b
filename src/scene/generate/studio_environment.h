// The light of a bare .hair file.
#pragma once

#include "scene/model/environment.h"

namespace tress::scene {

/// A soft studio for a camera at -y: key softbox upper left in front, long rim light behind and above, dim fill,
/// neutral background. Latitude-longitude map of 256 x 128.
Environment studio_environment(double rotate_rad, float scale);

}  // namespace tress::scene
