// One render, from the settings to the saved files, learning on the way.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/progress.h"
#include "cli/warm_cache_session.h"
#include "integrate/renderer.h"
#include "scene/read/load_scene.h"
#include "tress/adaptive/options.h"
#include "tress/fiber/elliptical_model.h"

namespace tress::cli {

/// What the names of the layers of light groups begin with.
inline constexpr std::string_view light_layer = "light.";

/// Every value in range: the command line has been checked.
struct RenderSettings {
  std::filesystem::path scene, output;  ///< output ends in .exr; a .png is written beside it
  std::string command;                  ///< as a shell takes it
  image::Precision precision = image::Precision::half;
  std::optional<std::vector<std::string>> layers;  ///< beside beauty; unset: all
  scene::Overrides overrides;
  integrate::RenderOptions render;       ///< samples come from the scene and its overrides
  StopRule stop;                         ///< instead of those samples
  std::optional<int> threads;            ///< unset: one per hardware thread that the process may use
  std::string model = "elliptical";      ///< of references::models()
  std::optional<int> quadrature_points;  ///< of models that have them
  fiber::Estimator estimator = fiber::Estimator::fitted;
  adaptive::Options table;
  std::optional<float> audited_share;  ///< of the samples, whose bias is measured
  std::optional<std::filesystem::path> warm_cache;
  CacheMode cache_mode = CacheMode::append;
  std::optional<std::filesystem::path> telemetry;
  bool telemetry_rows = false;
  std::optional<std::filesystem::path> heatmap;  ///< ends in .exr
};

/// Exit status of the command.
int run_render(const RenderSettings& settings);

}  // namespace tress::cli
