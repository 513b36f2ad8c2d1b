// Curves of USD: of a text, of a crate, and of an archive of both.
#pragma once

#include "scene/read/grooms/groom_formats.h"

namespace tress::scene {

std::span<const FormatItem> usd_items();
std::span<const FormatItem> usd_instancer_items();
Result<GroomFile> read_usda(const GroomInput& input);
Result<GroomFile> read_usdc(const GroomInput& input);
Result<GroomFile> read_usdz(const GroomInput& input);

}  // namespace tress::scene
