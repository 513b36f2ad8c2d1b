// Files of strands, of any format that can be read.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "scene/read/grooms/groom_file.h"

namespace tress::scene {

/// Reads a regular file of strands, told by its content; where that tells nothing, by the ending of its name. The file
/// is mapped, not copied: it must not be cut while it is read. points_per_strand: of formats that do not say. frame and
/// frames_per_second: as of GroomInput.
Result<GroomFile> read_groom_file(const std::filesystem::path& file,
                                  std::optional<std::uint32_t> points_per_strand = {}, std::optional<double> frame = {},
                                  double frames_per_second = 24);

/// Whether read_groom_file() has a format for it, by its content or else by its name, or knows what makes one of it.
/// False where it cannot be read.
bool is_groom_file(const std::filesystem::path& file);

}  // namespace tress::scene
