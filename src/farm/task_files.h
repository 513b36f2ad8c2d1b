// The files of a farm's folder, one set for each task, and the state of a task that they show. Many machines share the
// folder.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "tress/base/error.h"

namespace tress::farm {

/// Files below the folder of a farm. Names of pictures, checkpoints and parts have #### if the plan has frames.
struct TaskFiles {
  std::filesystem::path state, cache, checkpoint, telemetry;
  std::filesystem::path picture, part;  ///< `part` is for a task that renders a share of the samples
};
/// stills: whether pictures have no number.
TaskFiles task_files(const std::filesystem::path& folder, std::size_t task, bool stills);
/// The file with the state of the merge.
std::filesystem::path merge_state_file(const std::filesystem::path& folder);
/// Makes the folders of those files. Error if one cannot be made.
std::optional<Error> make_folders(const std::filesystem::path& folder);

enum class Phase {
  waiting,      ///< not begun
  running,      ///< a process works on it now, or was killed: see is_held()
  interrupted,  ///< ended by a signal with everything saved
  failed,       ///< tried as often as allowed
  done,
};
const char* phase_name(Phase phase);

struct TaskState {
  Phase phase = Phase::waiting;
  int attempts = 0;       ///< begun, and not ended by a signal
  int status = 0;         ///< exit status of the last attempt
  std::string host, job;  ///< place of the last attempt; job: the scheduler's id, may be empty
};
/// The state in the file; waiting if the file does not exist or cannot be parsed.
TaskState read_state(const std::filesystem::path& file);
std::optional<Error> write_state(const std::filesystem::path& file, const TaskState& state);

/// Whether a process holds the SaveLock of `file` now. False on a file system without locks.
bool is_held(const std::filesystem::path& file);

}  // namespace tress::farm
