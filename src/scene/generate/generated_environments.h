// Environments that need no picture: a studio, and a sky of three colors.
#pragma once

#include <glm/vec3.hpp>

#include "scene/model/environment.h"

namespace tress::scene {

/// The light for a bare .hair file: a soft studio for a camera at -y, with a key softbox upper left in front, a long
/// rim light behind and above, a dim fill and a neutral background. Latitude-longitude map of 256 x 128.
Environment studio_environment(double rotate_rad, float scale);

/// Radiances, linear RGB, >= 0. Above the horizon the color goes from `horizon` to `zenith` with the square root of the
/// sine of the elevation, so that the pale band is narrow, as in a clear sky; below it is `ground`.
struct GradientSky {
  glm::vec3 zenith{0.18f, 0.32f, 0.70f}, horizon{0.75f, 0.82f, 0.90f}, ground{0.22f, 0.20f, 0.18f};
};

/// The sky as a map of one column, which is importance sampled like any map; rows have the mean over their solid angle.
Environment gradient_environment(const GradientSky& sky, float scale);

}  // namespace tress::scene
