// The files of a farm's folder, one set a task, and what is known of a task from them. Many machines share the folder.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "tress/base/error.h"

namespace tress::farm {

/// Below the folder of a farm. Names of pictures, checkpoints and parts have #### where the plan has frames.
struct TaskFiles {
  std::filesystem::path state, cache, checkpoint, telemetry;
  std::filesystem::path picture, part;  ///< of a task that renders a share of the samples
};
/// stills: pictures have no number.
TaskFiles task_files(const std::filesystem::path& folder, std::size_t task, bool stills);
/// What the merge tells of itself.
std::filesystem::path merge_state_file(const std::filesystem::path& folder);
/// Makes the folders that those files are in. Error if one cannot be made.
std::optional<Error> make_folders(const std::filesystem::path& folder);

enum class Phase {
  waiting,      ///< nobody has begun it
  running,      ///< a process works at it now, or was killed: see is_held()
  interrupted,  ///< ended by a signal with everything saved
  failed,       ///< as often as it may
  done,
};
const char* phase_name(Phase phase);

struct TaskState {
  Phase phase = Phase::waiting;
  int attempts = 0;       ///< begun and not ended by a signal
  int status = 0;         ///< exit status of the last one
  std::string host, job;  ///< of the last one; job: as the scheduler calls it, may be empty
};
/// What the file says; waiting if there is none or it cannot be understood.
TaskState read_state(const std::filesystem::path& file);
std::optional<Error> write_state(const std::filesystem::path& file, const TaskState& state);

/// Whether a process holds the SaveLock of `file` now. Where a file system has no locks: false.
bool is_held(const std::filesystem::path& file);

}  // namespace tress::farm
