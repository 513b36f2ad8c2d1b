// Strands of Alembic archives (Ogawa).
#pragma once

#include "scene/read/grooms/groom_formats.h"

namespace tress::scene {

std::span<const FormatItem> alembic_items();
Result<GroomFile> read_alembic(const GroomInput& input);

}  // namespace tress::scene
