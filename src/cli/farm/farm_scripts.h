// The scripts of a farm, and its submission to a scheduler.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cli/farm/farm_commands.h"
#include "farm/slurm.h"

namespace tress::cli {

/// Writes the files of every scheduler into the folder of the farm; those of Slurm are for the tasks that are left.
std::optional<Error> write_scripts(const Farm& opened, const farm::SlurmOptions& options,
                                   const std::vector<std::size_t>& left);

/// Submits the tasks that are left and the merge, and notes the jobs in FOLDER/submitted.json. Returns the exit status.
int submit_to_slurm(const Farm& opened, const farm::SlurmOptions& options, const std::vector<std::size_t>& left);

/// The ids of earlier jobs that Slurm still has in its queue, separated by commas; empty if it has none of them.
std::string jobs_in_queue(const std::filesystem::path& folder);

/// Prints the commands for this scheduler, or for all of them if it is "none".
void print_commands(const Farm& opened, const std::string& scheduler);

}  // namespace tress::cli
