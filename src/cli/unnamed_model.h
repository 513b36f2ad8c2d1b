// The fiber model of a command line without --model: references::choose_model(), and a note where it is not the
// default.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>

#include "scene/model/scene.h"

namespace tress::cli {

/// name: of references::models(). of_scene: nothing has named it, so that the scene may, once it is read; to
/// needs_rows, whether an option was given that only models with rows have.
struct UnnamedModel {
  std::string name;
  bool of_scene = false;
  bool needs_rows = false;
};

/// By the options of the command and by the cache that rows are read from (empty: none).
UnnamedModel model_of_command(const CLI::App& command, const std::filesystem::path& warm_cache);

/// By the scene's materials.
std::string model_of_scene(const scene::Scene& scene, bool needs_rows);

}  // namespace tress::cli
