// Parses frame lists of the command line; base/numbered_file.h has the names of their files.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/numbered_file.h"  // IWYU pragma: export

namespace tress::cli {

/// Parses "1-240,250,300-340x2": single frames and ranges, where x takes every n-th frame. The frames are in the given
/// order, each once. Empty if the text is no list of frames, a frame is beyond 1,000,000, or there are too many.
std::optional<std::vector<int>> parse_frames(const std::string& text);

}  // namespace tress::cli
