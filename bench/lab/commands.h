// The commands that only tress-lab has; each has its file.
#pragma once

#include "cli/commands.h"

namespace tress::lab {

cli::Command add_fit(CLI::App& program);
cli::Command add_far_field(CLI::App& program);
cli::Command add_lobes(CLI::App& program);
cli::Command add_measure(CLI::App& program);

}  // namespace tress::lab
