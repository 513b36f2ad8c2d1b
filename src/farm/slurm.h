// A farm as jobs of Slurm: arrays of tasks, and a merge that waits for them. Needs nothing but sbatch and scontrol.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "farm/plan.h"

namespace tress::farm {

/// One word as a POSIX shell takes it, in quotes where it would be taken apart.
std::string shell_word(const std::string& word);
/// The words with spaces between.
std::string shell_words(const std::vector<std::string>& words);

/// What sbatch is given beside the scripts.
struct SlurmOptions {
  std::string name;                ///< of the jobs
  int at_most = 0;                 ///< tasks at a time; 0: as many as there are nodes
  std::vector<std::string> extra;  ///< options of sbatch, as they are
};

/// A batch script that runs one task of its array. Starts again, by `scontrol requeue`, what failed and may be tried
/// again (exit status 75), what was killed while it may, and what the limit of time has stopped.
std::string slurm_task_script(const Plan& plan, const std::filesystem::path& folder);
/// A batch script that merges.
std::string slurm_merge_script(const Plan& plan, const std::filesystem::path& folder);

/// The command that submits such a script; prints the id of the job. after: ids of jobs that must have succeeded.
/// offset: at most the first of the tasks; their numbers in the array are that much less, since Slurm numbers no
/// further than MaxArraySize.
std::vector<std::string> slurm_array_command(const std::filesystem::path& folder, const SlurmOptions& options,
                                             const std::vector<std::size_t>& tasks,
                                             const std::vector<std::string>& after, std::size_t offset = 0);
std::vector<std::string> slurm_merge_command(const std::filesystem::path& folder, const SlurmOptions& options,
                                             const std::vector<std::string>& after);

}  // namespace tress::farm
