// tress cache prebake: the whole table of a scene beforehand, as the paper makes its own.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "scene/read/load_scene.h"
#include "tress/adaptive/options.h"

namespace tress::cli {

/// Every value in range: the command line has been checked.
struct PrebakeSettings {
  std::filesystem::path scene, output;
  scene::Overrides overrides;
  std::string model = "elliptical";  ///< of references::models(), with rows
  adaptive::Options table;
  std::optional<int> threads;
  std::optional<std::filesystem::path> telemetry;
};

/// Empty if all is well; else what contradicts what, as a message: wrong usage.
std::string contradiction(const PrebakeSettings& settings);

/// Learns every row of every slice that the fibers of the scene have and saves them as a warm cache, replacing one that
/// is there. Rows that did not converge are counted on stderr and saved as open. Exit status: 0, also with such rows; 1
/// with nothing written; 130, 143 or 129 after a signal, with what was learned by then.
int run_prebake(const PrebakeSettings& settings);

}  // namespace tress::cli
