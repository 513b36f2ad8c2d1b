// A groom as a file has it into a file of another format.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scene/read/grooms/groom_file.h"

namespace tress::scene {

/// The endings that write_groom_file() knows: ".hair", ".usda".
const std::vector<std::string>& groom_output_endings();

/// By the ending of the name. .usda keeps the basis, the unit and the axis that is up, widths, colors, normals, ids and
/// root uv. .hair has points, widths and colors alone: it is written in centimetres with z up where the file says its
/// own, and Bezier segments and open B-splines as points on the curve, four a segment. Strands without points are left
/// out. Appends to `notes` what the new file will not have. The old file stays until the new one is whole.
std::optional<Error> write_groom_file(const GroomFile& groom, const std::filesystem::path& file,
                                      std::vector<std::string>* notes);

}  // namespace tress::scene
