// A file of named sections, packed, with checksums: what a checkpoint and a part of a picture are stored in
// (src/cli/CHECKPOINT.md has it byte by byte).
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tress/base/error.h"

namespace tress {

/// Names are 1 to 64 printable ASCII characters, each once.
using Sections = std::vector<std::pair<std::string, std::string_view>>;

/// Replaces the file, as replace_file() does: old or new, whole at every moment.
std::optional<Error> write_sections(const std::filesystem::path& file, const Sections& sections);

/// All sections by their names. Error, naming the place, if the file is no such file, is cut, has more at its end, or a
/// piece of a section is not what its checksum says. Takes at most 64 times the memory of the file.
Result<std::map<std::string, std::string>> read_sections(const std::filesystem::path& file);

}  // namespace tress
