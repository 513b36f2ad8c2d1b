// Checks the claims of an EXR header before OpenEXR reads it. OpenEXR allocates what a header asks for, and a header of
// a few hundred bytes can ask for gigabytes.
#pragma once

#include <filesystem>
#include <optional>

#include "tress/base/error.h"

namespace tress::image {

/// Returns an error, with the attribute, if the claims of the file's headers are impossible or too large. The value of
/// every attribute must lie in the file and be as long as its type. The data window must have 1 to most_pixels pixels,
/// a tile must take at most 2^28 bytes, and the table of the picture's blocks must fit into the file. OpenEXR finds
/// other kinds of damage.
std::optional<Error> check_exr_header(const std::filesystem::path& file, std::int64_t most_pixels);

}  // namespace tress::image
