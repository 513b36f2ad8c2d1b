// Environments that need no picture: a studio, and a sky of three colors.
#pragma once

#include <glm/vec3.hpp>

#include "scene/model/environment.h"

namespace tress::scene {

/// The light of a bare .hair file: a soft studio for a camera at -y: key softbox upper left in front, long rim light
/// behind and above, dim fill, neutral background. Latitude-longitude map of 256 x 128.
Environment studio_environment(double rotate_rad, float scale);

/// Radiance, linear RGB, >= 0. Above the horizon from `horizon` to `zenith` with the square root of the sine of the
/// elevation, so that the pale band is narrow as in a clear sky; below it `ground`.
struct GradientSky {
  glm::vec3 zenith{0.18f, 0.32f, 0.70f}, horizon{0.75f, 0.82f, 0.90f}, ground{0.22f, 0.20f, 0.18f};
};

/// As a map of one column, so that its importance sampling is the map's; rows hold the mean over their solid angle.
Environment gradient_environment(const GradientSky& sky, float scale);

}  // namespace tress::scene
