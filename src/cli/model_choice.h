// The fiber model of a command: the one that --model names, else that of the scene's materials; and the options that
// the model must have.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "models/model_options.h"
#include "scene/model/scene.h"
#include "tress/fiber/elliptical_model.h"

namespace tress::cli {

/// fiber::default_model() of the scene, with a note where it is not the usual one. The name is of fiber::models().
std::string model_of_scene(const scene::Scene& scene);

/// The options of the command that not every model has.
std::vector<fiber::AskedOption> model_options(const CLI::App& command, fiber::Estimator estimator);

/// Empty if the model has them all; else what was expected, and what to do. is_named: by --model.
std::string refused_option(const std::vector<fiber::AskedOption>& asked, const std::string& model, bool is_named);
/// The same where no model is named and no scene is read yet: of options that no scene's model has.
std::string refused_by_all(const std::vector<fiber::AskedOption>& asked);

/// Warns of materials whose medulla the model leaves out.
void tell_lost_medullas(const scene::Scene& scene, const std::string& model);

}  // namespace tress::cli
