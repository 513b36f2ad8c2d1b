// Strands of .hair files (README.md).
#pragma once

#include "scene/read/grooms/groom_formats.h"

namespace tress::scene {

std::span<const FormatItem> hair_items();

/// Parses the bytes. `name` is the file named in errors, which give the byte.
Result<GroomFile> parse_hair_file(std::span<const unsigned char> bytes, const std::string& name,
                                  const DoneWith& done_with = {});

}  // namespace tress::scene
