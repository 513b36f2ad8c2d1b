// tress merge, denoise and diff: pictures and parts of them to a picture, or to what two differ by.
#pragma once

#include "cli/commands.h"

namespace tress::cli {

Command add_merge(CLI::App& tress);
Command add_denoise(CLI::App& tress);
Command add_diff(CLI::App& tress);

}  // namespace tress::cli
