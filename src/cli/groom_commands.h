// tress info and tress convert: describe a groom of any format or a scene, and write it in another format.
#pragma once

#include "cli/commands.h"

namespace tress::cli {

Command add_info(CLI::App& tress);
Command add_convert(CLI::App& tress);

}  // namespace tress::cli
