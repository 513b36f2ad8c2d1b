// Writes a groom from a file into a file of another format.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scene/read/grooms/groom_file.h"

namespace tress::scene {

/// The endings that write_groom_file() supports: ".hair", ".usda".
const std::vector<std::string>& groom_output_endings();

/// Chooses the format by the ending of the name. .usda keeps the basis, the unit, the up axis, widths, colors, normals,
/// ids and root uv. .hair has only points, widths and colors. It is written in centimetres with z up if the file
/// records its own. Bezier segments and open B-splines become points on the curve, four per segment. Strands without
/// points are left out. What the new file will lack is appended to `notes`. The old file stays until the new one is
/// whole.
std::optional<Error> write_groom_file(const GroomFile& groom, const std::filesystem::path& file,
                                      std::vector<std::string>* notes);

}  // namespace tress::scene
