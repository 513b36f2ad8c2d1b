// The plan of a farm: what to render, cut into tasks that any scheduler can start in any order.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tress/base/error.h"

namespace tress::farm {

/// The plan as requested; the file farm.json of the farm's folder. Paths are absolute.
struct Plan {
  std::filesystem::path program;    ///< the path of tress, the same on every machine
  std::filesystem::path directory;  ///< names of files in `options` are relative to it
  std::filesystem::path scene;
  std::filesystem::path output;                     ///< ends in .exr; #### stands for the frame number
  std::vector<int> frames;                          ///< in the order of rendering; empty: one still
  std::optional<std::filesystem::path> warm_cache;  ///< tasks start from it, and the merge saves into it
  bool frozen = false;                              ///< whether the cache is used without learning
  bool calibrates = false;           ///< the first frame is a task of its own; the others wait for its table
  int chunk = 1;                     ///< frames in a task, at least 1
  int split = 0;                     ///< number of tasks that share the samples of each frame; 0: frames are not split
  int samples = 0;                   ///< per pixel, where frames are split
  int retries = 2;                   ///< how often a failed task is tried again
  std::vector<std::string> options;  ///< options of tress render, passed to every task
};

/// A task: some frames, or a share of the samples of one frame.
struct Task {
  std::vector<int> frames;               ///< empty for a still
  int samples_from = 0, samples_to = 0;  ///< the end is excluded; both 0: all samples
  bool is_split() const { return samples_to > 0; }
};

/// The tasks in the order of their numbers, from 0. Pure: the same plan gives the same tasks.
std::vector<Task> tasks_of(const Plan& plan);

/// The frames as text, with runs of consecutive ones: "1-10,15".
std::string frames_text(const std::vector<int>& frames);
/// The numbers, ascending, as Slurm and OpenJD write them.
std::string ranges_text(const std::vector<std::size_t>& numbers);

/// Reads FOLDER/farm.json. Error if the file is missing, is no valid plan, or has a later version.
Result<Plan> read_plan(const std::filesystem::path& folder);
std::optional<Error> write_plan(const std::filesystem::path& folder, const Plan& plan);
/// The differences of two plans as text, "chunk: expected 2, found 4"; empty if they are equal.
std::string differences(const Plan& expected, const Plan& found);

}  // namespace tress::farm
