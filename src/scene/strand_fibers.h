// Which fiber each strand is of.
#pragma once

#include "scene/scene.h"

namespace tress::scene {

/// Fills scene->fibers with the distinct fibers that the materials give to the strands of the grooms, and every
/// groom's `fiber`. Materials must be in range.
void assign_fibers(Scene* scene);

}  // namespace tress::scene
