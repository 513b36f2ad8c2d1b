// Names of files that have the number of a frame in them: a.####.exr.
#pragma once

#include <filesystem>

namespace tress {

/// Whether the file name has a run of #, which stands for the number of a frame.
bool names_frames(const std::filesystem::path& file);
/// The last run of # in the file name becomes the number, with zeros before it to the length of the run.
std::filesystem::path of_frame(const std::filesystem::path& file, int frame);

}  // namespace tress
