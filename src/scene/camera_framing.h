// A camera that sees all of the hair.
#pragma once

#include <vector>

#include "scene/scene.h"

namespace tress::scene {

/// From -y and slightly above, at the vertical angle of view of `camera`, every point inside the picture with a small
/// margin. Without points: `camera` as it is.
Camera frame_grooms(const std::vector<Groom>& grooms, const Image& image, const Camera& camera);

}  // namespace tress::scene
