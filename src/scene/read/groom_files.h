// Reads files of strands in any supported format.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scene/read/grooms/groom_file.h"

namespace tress::scene {

/// Reads a regular file of strands. Its format is detected by its content, or else by the ending of its name. The file
/// is mapped, not copied: it must not be truncated while it is read. A gzip file is unpacked in memory, up to 4 GB. The
/// name "-" is standard input, which can be read once. points_per_strand: for formats that do not record it. frame,
/// frames_per_second, attribute and origin: as in GroomInput. settles: whether shared strands are, too.
Result<GroomFile> read_groom_file(const std::filesystem::path& file,
                                  std::optional<std::uint32_t> points_per_strand = {}, std::optional<double> frame = {},
                                  std::optional<double> frames_per_second = {}, const std::string& attribute = {},
                                  const glm::dvec3& origin = glm::dvec3(0.0), bool settles = true);

/// All files that a file of strands includes, directly or indirectly, whether they exist or not; empty for most
/// formats.
std::vector<std::filesystem::path> included_files(const std::filesystem::path& file);

/// Whether read_groom_file() supports its format, by content or else by name, or its error can advise how to convert
/// it. False if it cannot be read.
bool is_groom_file(const std::filesystem::path& file);

}  // namespace tress::scene
