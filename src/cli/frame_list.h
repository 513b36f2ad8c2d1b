// Frames as the command line has them; names of their files are in base/numbered_file.h.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/numbered_file.h"  // IWYU pragma: export

namespace tress::cli {

/// "1-240,250,300-340x2": single frames and ranges, of which the x takes every so many. In the order told, each once.
/// Unset if the text is no list of frames, a frame is beyond 1,000,000, or there are more than so many.
std::optional<std::vector<int>> parse_frames(const std::string& text);

}  // namespace tress::cli
