// The fiber model of a command: that of --model, or else that of the scene's materials; and a check of the options that
// it must support.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "models/model_options.h"
#include "scene/model/scene.h"
#include "tress/fiber/elliptical_model.h"

namespace tress::cli {

/// fiber::default_model() of the scene; logs a note if it is not the usual one. The name is one of fiber::models().
std::string model_of_scene(const scene::Scene& scene);

/// The options of the command that not every model supports.
std::vector<fiber::AskedOption> model_options(const CLI::App& command, fiber::Estimator estimator);

/// Empty if the model supports them all; otherwise what was expected, and what to do. is_named: by --model.
std::string refused_option(const std::vector<fiber::AskedOption>& asked, const std::string& model, bool is_named);
/// The same before a scene is read and without a named model: checks for options that no scene's model supports.
std::string refused_by_all(const std::vector<fiber::AskedOption>& asked);

/// Warns about what the scene asks for and the model lacks: parts of fibers (medulla, scattering cortex, water), hits
/// that are traced near.
void log_model_lacks(const scene::Scene& scene, const std::string& model);

}  // namespace tress::cli
