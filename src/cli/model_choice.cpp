#include "cli/model_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "cli/console.h"
#include "models/catalog.h"
#include "models/default_model.h"

namespace tress::cli {
namespace {

using fiber::AskedOption;
using fiber::Asks;

/// A message about a refused option, or about a command that works in the other way only.
std::string refusal_text(const fiber::RefusedOption& refused, const std::string& found, bool is_named) {
  return fmt::format("{}: expected {}, found {}: {} --model {}{}", refused.name, refused.expected, found,
                     is_named ? "give" : "add", refused.remedy,
                     refused.name.starts_with("--") ? ", or leave the option away" : "");
}

}  // namespace

std::string model_of_scene(const scene::Scene& scene) {
  std::vector<fiber::FiberParameters> materials;
  for (const scene::Material& material : scene.materials) materials.push_back(material.fiber);
  const fiber::ChosenModel chosen = fiber::default_model(materials, scene.fibers);
  if (!chosen.why.empty()) log_note(fmt::format("model {}: {}", chosen.info->name, chosen.why));
  return chosen.info->name;
}

std::vector<AskedOption> model_options(const CLI::App& command, fiber::Estimator estimator) {
  constexpr std::array<std::pair<const char*, Asks>, 9> options{{{"--learner", Asks::mixtures},
                                                                 {"--components", Asks::mixtures},
                                                                 {"--estimator", Asks::rows},
                                                                 {"--epsilon", Asks::rows},
                                                                 {"--picture-error", Asks::rows},
                                                                 {"--table-memory", Asks::rows},
                                                                 {"--measure-bias", Asks::rows},
                                                                 {"--near", Asks::samples},
                                                                 {"--quadrature-points", Asks::points}}};
  std::vector<AskedOption> asked;
  for (const auto& [name, what] : options) {
    const CLI::Option* option = command.get_option_no_throw(name);
    if (option != nullptr && option->count() > 0) asked.push_back({name, what});
  }
  if (estimator == fiber::Estimator::corrected) asked.push_back({"--estimator corrected", Asks::corrected});
  return asked;
}

std::string refused_option(const std::vector<AskedOption>& asked, const std::string& model, bool is_named) {
  const auto refused = fiber::refused(asked, *fiber::find_model(model));
  if (!refused) return {};
  return refusal_text(*refused, is_named ? "--model " + model : model + ", the model of the scene's materials",
                      is_named);
}

std::string refused_by_all(const std::vector<AskedOption>& asked) {
  const std::vector<const fiber::ModelInfo*> models = fiber::default_models();
  for (const AskedOption& option : asked) {
    if (std::ranges::any_of(models, [&](const fiber::ModelInfo* info) { return fiber::has(*info, option.what); }))
      continue;
    return refusal_text(*fiber::refused(std::array{option}, *models.front()), "no --model", false);
  }
  return {};
}

void log_model_lacks(const scene::Scene& scene, const std::string& model) {
  const fiber::ModelInfo& info = *fiber::find_model(model);
  const auto names = [](const auto& is_able) {
    std::string text;
    for (const fiber::ModelInfo& other : fiber::models())
      if (is_able(other)) text += (text.empty() ? "" : ", ") + std::string(other.name);
    return text;
  };
  const scene::Integrator& asked = scene.integrator;
  const auto traces = [](const fiber::ModelInfo& other) { return fiber::has(other, Asks::samples); };
  if ((asked.near ? asked.near != "nowhere" : asked.near_pixels.value_or(0) > 0) && !traces(info))
    log_warning(
        fmt::format("/integrator/near: left out by model {}, which has no rows or cannot trace its fibers; "
                    "models that have it: {}",
                    model, names(traces)));
  if (info.has_parts) return;
  for (const scene::Material& material : scene.materials) {
    const std::pair<const char*, bool> parts[] = {{"medulla", material.fiber.medulla_radius > 0},
                                                  {"cortex", material.fiber.cortex_scattering > 0},
                                                  {"wetness", material.fiber.wetness > 0}};
    for (const auto& [part, is_there] : parts)
      if (is_there)
        log_warning(fmt::format(
            "material {}: {}: left out by model {}, whose fibers have none; models that have it: {}", material.name,
            part, model, names([](const fiber::ModelInfo& other) { return other.has_parts; })));
  }
}

}  // namespace tress::cli
