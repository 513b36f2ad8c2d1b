#include "cli/unnamed_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "cli/console.h"
#include "references/default_model.h"

namespace tress::cli {
namespace {

/// That only models with rows have.
constexpr std::array options_of_rows{"--picture-error", "--table-memory", "--warm-cache", "--measure-bias"};

references::ChosenModel told(const references::ModelHints& hints) {
  references::ChosenModel chosen = references::choose_model(hints);
  if (!chosen.why.empty()) log_note(fmt::format("model {}: {}", chosen.name, chosen.why));
  return chosen;
}

}  // namespace

UnnamedModel model_of_command(const CLI::App& command, const std::filesystem::path& warm_cache) {
  references::ModelHints hints{.warm_cache = warm_cache};
  for (const char* name : {"--estimator", "--learner", "--components", "--epsilon"}) {
    const CLI::Option* option = command.get_option_no_throw(name);
    if (hints.option.empty() && option != nullptr && option->count() > 0) hints.option = name;
  }
  references::ChosenModel chosen = told(hints);
  const bool needs_rows = std::ranges::any_of(options_of_rows, [&](const char* name) {
    const CLI::Option* option = command.get_option_no_throw(name);
    return option != nullptr && option->count() > 0;
  });
  return {std::move(chosen.name), chosen.why.empty(), needs_rows};
}

std::string model_of_scene(const scene::Scene& scene, bool needs_rows) {
  return told({.needs_rows = needs_rows,
               .shapes_lobes = std::ranges::any_of(scene.materials, references::shapes_lobes, &scene::Material::fiber),
               .has_published_lobes = references::have_published_lobes(scene.fibers)})
      .name;
}

}  // namespace tress::cli
