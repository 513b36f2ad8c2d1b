// What a farm is to render, cut into tasks that any scheduler can start in any order.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tress/base/error.h"

namespace tress::farm {

/// As it was asked for; the file farm.json of its folder. Paths are absolute.
struct Plan {
  std::filesystem::path program;    ///< tress, as every machine finds it
  std::filesystem::path directory;  ///< in which names of files in `options` are looked up
  std::filesystem::path scene;
  std::filesystem::path output;                     ///< ends in .exr; #### is the number of the frame
  std::vector<int> frames;                          ///< in the order in which they are rendered; empty: one still
  std::optional<std::filesystem::path> warm_cache;  ///< which the tasks start from and the merge saves into
  bool frozen = false;                              ///< the cache is used as it is
  bool calibrates = false;           ///< the first task is the first frame alone, and the others wait for its table
  int chunk = 1;                     ///< frames of a task, at least 1
  int split = 0;                     ///< tasks that share the samples of each frame; 0: none do
  int samples = 0;                   ///< of a pixel, where they are split
  int retries = 2;                   ///< of a task that fails
  std::vector<std::string> options;  ///< of tress render, handed to every task
};

/// Frames, or samples of one frame.
struct Task {
  std::vector<int> frames;               ///< empty: a still
  int samples_from = 0, samples_to = 0;  ///< the second excluded; both 0: all samples
  bool is_split() const { return samples_to > 0; }
};

/// In the order of their numbers, from 0. Pure: the same plan has the same tasks.
std::vector<Task> tasks_of(const Plan& plan);

/// "1-10,15": runs of frames that follow one another.
std::string frames_text(const std::vector<int>& frames);
/// The numbers, ascending, as Slurm and OpenJD take them.
std::string ranges_text(const std::vector<std::size_t>& numbers);

/// FOLDER/farm.json. Error if the file is not there, is no plan, or of a later version.
Result<Plan> read_plan(const std::filesystem::path& folder);
std::optional<Error> write_plan(const std::filesystem::path& folder, const Plan& plan);
/// What two plans say differently, "chunk: expected 2, found 4"; empty if nothing.
std::string differences(const Plan& expected, const Plan& found);

}  // namespace tress::farm
