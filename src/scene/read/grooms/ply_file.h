// Strands of PLY files.
#pragma once

#include "scene/read/grooms/groom_formats.h"

namespace tress::scene {

std::span<const FormatItem> ply_items();
Result<GroomFile> read_ply(const GroomInput& input);

}  // namespace tress::scene
