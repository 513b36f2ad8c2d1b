// Curves of scenes of pbrt.
#pragma once

#include "scene/read/grooms/groom_formats.h"

namespace tress::scene {

std::span<const FormatItem> pbrt_items();
std::span<const FormatItem> pbrt_curve_items();
/// Whether a text begins like a scene of pbrt.
bool is_pbrt(std::span<const unsigned char> bytes);
/// The names after Include and Import; empty for another file.
std::vector<std::string> pbrt_includes(std::span<const unsigned char> bytes);
Result<GroomFile> read_pbrt(const GroomInput& input);

}  // namespace tress::scene
