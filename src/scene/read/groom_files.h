// Files of strands, of any format that can be read.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scene/read/grooms/groom_file.h"

namespace tress::scene {

/// Reads a regular file of strands, told by its content; where that tells nothing, by the ending of its name. The file
/// is mapped, not copied: it must not be cut while it is read. What gzip packed is unpacked in memory, at most 4 GB of
/// it; the name "-" is standard input, which can be read once. points_per_strand: of formats that do not say. frame,
/// frames_per_second and attribute: as of GroomInput.
Result<GroomFile> read_groom_file(const std::filesystem::path& file,
                                  std::optional<std::uint32_t> points_per_strand = {}, std::optional<double> frame = {},
                                  std::optional<double> frames_per_second = {}, const std::string& attribute = {});

/// The files that a file of strands includes, and those that these do, whether they are there or not; none of most
/// formats.
std::vector<std::filesystem::path> included_files(const std::filesystem::path& file);

/// Whether read_groom_file() has a format for it, by its content or else by its name, or knows what makes one of it.
/// False where it cannot be read.
bool is_groom_file(const std::filesystem::path& file);

}  // namespace tress::scene
