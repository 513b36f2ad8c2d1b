// A file of named, packed sections with checksums. Checkpoints and parts of pictures are stored in it
// (src/cli/CHECKPOINT.md defines every byte).
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

namespace tress::inline v0_2 {

/// Names are 1 to 64 printable ASCII characters, each once.
using Sections = std::vector<std::pair<std::string, std::string_view>>;

/// Replaces the file as replace_file() does: it is whole, old or new, at every moment.
std::optional<Error> write_sections(const std::filesystem::path& file, const Sections& sections);

/// Returns all sections by their names. Error, with the place, if the file has another format, is cut, has more bytes
/// at its end, or a piece does not have its checksum. Takes at most 64 times the memory of the file.
Result<std::map<std::string, std::string>> read_sections(const std::filesystem::path& file);

}  // namespace tress::inline v0_2
