// What an EXR file claims before OpenEXR believes it: OpenEXR allocates what a header asks for, a few hundred bytes of
// which can ask for gigabytes.
#pragma once

#include <filesystem>
#include <optional>

#include "tress/base/error.h"

namespace tress::image {

/// Why the claims of the file's headers cannot be true or are too large, by the attribute: the value of every attribute
/// lies in the file and is as long as its type, the data window has 1 to most_pixels pixels, a tile takes at most 2^28
/// bytes, and the table of the picture's blocks fits into the file. Damage of other kinds is left to OpenEXR.
std::optional<Error> check_exr_header(const std::filesystem::path& file, std::int64_t most_pixels);

}  // namespace tress::image
