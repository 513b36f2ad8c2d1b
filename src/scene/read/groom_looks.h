// Grooms of which some strands have another material.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scene/read/scene_file.h"
#include "tress/base/error.h"

namespace tress::scene {

/// Divides a groom by its looks: first the strands that keep groom.material, then those of each look, in their order.
/// Parts have the names of the groom, and strands keep their ids. Parts without strands are left out. Which look a
/// strand has depends on its id and the groom's object, not on the other strands. Without looks: the groom itself.
std::vector<Groom> divided(Groom groom, const std::vector<GroomLook>& looks);

}  // namespace tress::scene
