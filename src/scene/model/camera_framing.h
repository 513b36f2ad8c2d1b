// A camera that sees all of the hair.
#pragma once

#include <vector>

#include "scene/model/scene.h"

namespace tress::scene {

/// From -y and slightly above, or from `turn_rad` counter-clockwise of -y, at the vertical angle of view of `camera`,
/// every point inside the picture with a small margin. Without points: `camera` as it is.
Camera frame_grooms(const std::vector<Groom>& grooms, const Image& image, const Camera& camera, double turn_rad = 0);

/// The same from a distance at which every point stays inside while the camera goes around `look_at` (the middle of the
/// hair where unset) on a level circle. Without points: `camera` as it is.
Camera frame_grooms_all_round(const std::vector<Groom>& grooms, const Image& image, const Camera& camera,
                              const std::optional<glm::vec3>& look_at);

/// Middle of the bounding box of all points; nothing without any.
std::optional<glm::vec3> middle_of(const std::vector<Groom>& grooms);

}  // namespace tress::scene
