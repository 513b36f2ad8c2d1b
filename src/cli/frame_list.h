// Frames as the command line has them, and the names of their files.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace tress::cli {

/// "1-240,250,300-340x2": single frames and ranges, of which the x takes every so many. In the order told, each once.
/// Unset if the text is none, a frame is beyond 1,000,000, or there are more than so many.
std::optional<std::vector<int>> parse_frames(const std::string& text);

/// Whether the file name has a run of #, which stands for the number of a frame.
bool names_frames(const std::filesystem::path& file);
/// The last run of # in the file name becomes the number, with zeros before it to the length of the run.
std::filesystem::path of_frame(const std::filesystem::path& file, int frame);

}  // namespace tress::cli
