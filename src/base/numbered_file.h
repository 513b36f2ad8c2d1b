// Names of files that contain the number of a frame: a.####.exr.
#pragma once

#include <filesystem>

namespace tress::inline v0_2 {

/// Whether the file name has a run of #, which stands for the number of a frame.
bool names_frames(const std::filesystem::path& file);
/// Replaces the last run of # in the file name by the number, with leading zeros to the length of the run.
std::filesystem::path of_frame(const std::filesystem::path& file, int frame);

}  // namespace tress::inline v0_2
