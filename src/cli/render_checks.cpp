#include "cli/render_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "cli/console.h"
#include "cli/options.h"
#include "cli/output_files.h"
#include "denoise/denoised_layer.h"
#include "scene/model/light.h"

namespace tress::cli {
namespace {

/// Finds a group in --layers that the scene does not have.
std::optional<Error> unknown_group(const RenderSettings& settings, const scene::Scene& scene) {
  const std::vector<std::string> groups = scene::light_groups(scene);
  for (const std::string& layer : settings.layers.value_or(std::vector<std::string>{})) {
    if (!layer.starts_with(light_layer) || std::ranges::count(groups, layer.substr(light_layer.size())) > 0) continue;
    return Error{"", "--layers",
                 groups.empty() ? "layers of a scene whose lights have no `group`"
                                : "light. with one of the groups " + joined(groups, ", "),
                 layer};
  }
  return std::nullopt;
}

/// A learned answer is a color, which cannot be divided among lights.
std::optional<Error> answered_groups(const RenderSettings& settings, const scene::Scene& scene) {
  if (!scene.integrator.learns_deep_light() || scene::light_groups(scene).empty()) return std::nullopt;
  return Error{settings.scene.string(), "/integrator/deep_light",
               "traced in a scene whose lights have a `group`, since what is learned is of all lights", "learned"};
}

/// Parts have as many samples of each pixel.
std::optional<Error> uneven_samples(const RenderSettings& settings, const scene::Scene& scene) {
  if (!scene.integrator.adaptive.value_or(false) || !(settings.samples_from || settings.samples_to))
    return std::nullopt;
  return Error{settings.scene.string(), "/integrator/adaptive",
               "false with --samples-from and --samples-to, whose pixels have as many samples", "true"};
}

/// Checks that all outputs can be written, before anything is rendered.
std::optional<Error> check_outputs(const RenderSettings& settings) {
  std::filesystem::path preview = settings.output;
  preview.replace_extension(".png");
  if (auto error = check_output(settings.output)) return error;
  if (auto error = check_output(preview)) return error;
  if (settings.heatmap) {
    if (auto error = check_output(*settings.heatmap)) return error;
  }
  if (settings.deep) {
    if (auto error = check_output(*settings.deep)) return error;
  }
  if (settings.checkpoint) {
    if (auto error = check_output(checkpoint_file(settings))) return error;
  }
  if (settings.part) {
    if (auto error = check_output(*settings.part)) return error;
  }
  if (settings.warm_cache && settings.cache_mode != CacheMode::frozen) {
    return is_default_cache(*settings.warm_cache) ? check_default_cache() : check_output(*settings.warm_cache);
  }
  return std::nullopt;
}

std::optional<Error> wrong_range(const RenderSettings& settings, const scene::Scene& scene) {
  if (const auto& crop = settings.render.crop) {
    const auto [x0, y0, x1, y1] = edges_of(*crop);
    if (x1 > scene.image.width || y1 > scene.image.height) {
      return Error{"", "--crop", fmt::format("pixels within {} x {}", scene.image.width, scene.image.height),
                   fmt::format("{},{},{},{}", x0, y0, x1, y1)};
    }
  }
  const SampleRange samples = samples_of(settings, scene);
  if (samples.from < samples.to) return std::nullopt;
  return Error{"", "--samples-from", fmt::format("a sample before {}, where they end", samples.to),
               std::to_string(samples.from)};
}

std::optional<Error> too_few_samples(const RenderSettings& settings, const scene::Scene& scene) {
  const SampleRange samples = samples_of(settings, scene);
  if (!settings.denoise || samples.to - samples.from >= denoise::least_samples) return std::nullopt;
  return Error{"", "--denoise", fmt::format("{} samples a pixel at least", denoise::least_samples),
               std::to_string(samples.to - samples.from)};
}

}  // namespace

std::array<int, 4> edges_of(const image::Window& window) {
  return {window.left, window.top, window.left + window.width, window.top + window.height};
}

int log_refusal(const RenderSettings& settings, const scene::Scene& scene) {
  for (const auto& check : {wrong_range, unknown_group, too_few_samples, answered_groups, uneven_samples}) {
    if (const std::optional<Error> error = check(settings, scene)) {
      log_error(error->message());
      return 2;
    }
  }
  if (const std::optional<Error> error = check_outputs(settings)) {
    log_error(error->message());
    return 1;
  }
  return 0;
}

}  // namespace tress::cli
