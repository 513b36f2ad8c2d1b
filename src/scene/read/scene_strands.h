// The strands of a whole scene, as a groom that can be written to a file.
#pragma once

#include "scene/model/scene.h"
#include "scene/read/grooms/groom_file.h"
#include "tress/base/error.h"

namespace tress::scene {

/// All strands of the scene as one groom, a part for each groom of it: in centimetres, z up, where they are at the
/// moment that the shutter opens, with the widths (diameters) that a picture has. Colors where every groom has its own;
/// what materials say stays behind. Error: no strands, or grooms whose curves are of different bases.
Result<GroomFile> strands_of(const Scene& scene);

}  // namespace tress::scene
