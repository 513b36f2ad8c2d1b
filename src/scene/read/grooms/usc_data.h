// Strands of the .data files of USC, which have no mark.
#pragma once

#include "scene/read/grooms/groom_formats.h"

namespace tress::scene {

std::span<const FormatItem> usc_data_items();
/// Whether the counts of strands and points give exactly the size of the file.
bool is_usc_data(std::span<const unsigned char> bytes);
Result<GroomFile> read_usc_data(const GroomInput& input);

}  // namespace tress::scene
