// The strands of a whole scene, as a groom that can be written to a file.
#pragma once

#include "scene/model/scene.h"
#include "scene/read/grooms/groom_file.h"
#include "tress/base/error.h"

namespace tress::scene {

/// All strands of the scene as one groom, with a part for each groom, instances written out: in centimetres, z up, at
/// the opening of the shutter, with the widths (diameters) of a picture. It has colors if every groom has its own;
/// materials are not included. Error: no strands, or grooms with curves of different bases.
Result<GroomFile> strands_of(const Scene& scene);

}  // namespace tress::scene
