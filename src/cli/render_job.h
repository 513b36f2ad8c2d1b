// One render, from the settings to the saved files, learning on the way.
#pragma once

#include <filesystem>
#include <map>
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
  std::optional<bool> adaptive;          ///< unset: where `stop` ends the render by noise or time
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
  std::optional<std::filesystem::path> heatmap;     ///< ends in .exr
  std::map<std::string, std::string> told;          ///< options that change the picture, by name, as they were given
  std::vector<int> frames;                          ///< empty: one picture; else names of files may have ####
  bool overwrite = false;                           ///< frames that are finished are rendered again
  bool seed_of_frame = true;                        ///< no seed was given: that of a frame is its number
  std::optional<std::filesystem::path> checkpoint;  ///< empty: beside the output
  double checkpoint_interval = 30;                  ///< seconds
  double checkpoint_deadline = 20;                  ///< seconds that a pass may go on after a signal
  std::optional<int> samples_from, samples_to;      ///< of the samples of a pixel, the second excluded
  std::optional<std::filesystem::path> part;        ///< what `tress merge` takes
};

/// Exit status of the command. Of many frames: 0 if all are there, 1 if one could not be rendered, the others were.
int run_render(const RenderSettings& settings);

}  // namespace tress::cli
