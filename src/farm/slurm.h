// Runs a farm as jobs of Slurm: arrays of tasks, and a merge that waits for them. Needs only sbatch and scontrol.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "farm/plan.h"

namespace tress::farm {

/// Quotes one word for a POSIX shell, if it needs quotes.
std::string shell_word(const std::string& word);
/// Joins the quoted words with spaces.
std::string shell_words(const std::vector<std::string>& words);

/// Options for sbatch besides the scripts.
struct SlurmOptions {
  std::string name;                ///< name of the jobs
  int at_most = 0;                 ///< largest number of tasks at a time; 0: as many as there are nodes
  std::vector<std::string> extra;  ///< options of sbatch, passed on unchanged
};

/// A batch script that runs one task of its array. By `scontrol requeue` it restarts a task that failed and may be
/// tried again (exit status 75), that was killed and may be tried again, or that the time limit stopped.
std::string slurm_task_script(const Plan& plan, const std::filesystem::path& folder);
/// A batch script that merges.
std::string slurm_merge_script(const Plan& plan, const std::filesystem::path& folder);

/// The command that submits such a script; it prints the id of the job. after: ids of jobs that must have succeeded.
/// offset: at most the number of the first task. It is subtracted from the numbers in the array, because Slurm limits
/// them to MaxArraySize.
std::vector<std::string> slurm_array_command(const std::filesystem::path& folder, const SlurmOptions& options,
                                             const std::vector<std::size_t>& tasks,
                                             const std::vector<std::string>& after, std::size_t offset = 0);
std::vector<std::string> slurm_merge_command(const std::filesystem::path& folder, const SlurmOptions& options,
                                             const std::vector<std::string>& after);

}  // namespace tress::farm
