// The settings of `tress render`: everything that the command line passes to the render.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/progress.h"
#include "cli/warm_cache_session.h"
#include "integrate/renderer.h"
#include "models/catalog.h"
#include "models/default_model.h"
#include "models/model_options.h"
#include "scene/read/load_scene.h"
#include "tress/adaptive/options.h"
#include "tress/fiber/elliptical_model.h"

namespace tress::cli {

/// The prefix of the layers of light groups.
inline constexpr std::string_view light_layer = "light.";
/// The word for integrate::half_layers in --layers.
inline constexpr std::string_view half_pictures = "half";

/// Every value is in range, because the command line has been checked.
struct RenderSettings {
  std::filesystem::path scene, output;  ///< output ends in .exr; a .png is written beside it
  std::string command;                  ///< in the syntax of a shell
  image::Precision precision = image::Precision::half;
  std::optional<std::vector<std::string>> layers;  ///< besides beauty; unset: all
  bool keeps_halves = false;                       ///< whether integrate::half_layers are written
  bool denoise = false;                            ///< whether to filter at the end; `render` then has halves
  scene::Overrides overrides;
  integrate::RenderOptions render;        ///< samples and what Scene::integrator has come from the scene
  StopRule stop;                          ///< replaces the scene's samples
  std::optional<int> threads;             ///< unset: one per hardware thread that the process may use
  std::string model{fiber::usual_model};  ///< one of fiber::models()
  bool model_of_scene = false;            ///< without --model: use that of the scene's materials
  std::vector<fiber::AskedOption> asked;  ///< options that the model must support
  std::optional<int> quadrature_points;   ///< for models that use them
  fiber::Estimator estimator = fiber::Estimator::fitted;
  adaptive::Options table;
  std::optional<float> audited_share;  ///< share of the samples that measure the bias
  std::optional<std::filesystem::path> warm_cache;
  CacheMode cache_mode = CacheMode::append;
  std::uint64_t cache_limit = std::uint64_t{1} << 30;  ///< limit of default_cache, bytes
  std::optional<std::filesystem::path> telemetry;
  bool telemetry_rows = false;
  std::optional<std::filesystem::path> heatmap;      ///< ends in .exr
  std::optional<std::filesystem::path> deep;         ///< ends in .exr
  std::map<std::string, std::string> given_options;  ///< options that change the picture, by name, as they were given
  std::vector<int> frames;                           ///< empty: one picture; else names of files may have ####
  bool overwrite = false;                            ///< whether finished frames are rendered again
  bool seed_of_frame = true;                         ///< no seed was given: use the number of the frame
  std::optional<std::filesystem::path> checkpoint;   ///< empty: beside the output
  double checkpoint_interval = 30;                   ///< seconds
  double checkpoint_deadline = 20;                   ///< seconds for which a pass may continue after a signal
  std::optional<int> samples_from, samples_to;       ///< range of a pixel's samples; the end is excluded
  std::optional<std::filesystem::path> part;         ///< output for `tress merge`
  std::optional<std::string> display_server;         ///< HOST:PORT of a viewer
  std::optional<std::string> serve;                  ///< ADDRESS:PORT of the live page; empty: a free port
  std::optional<std::filesystem::path> serve_reference;
};

/// The estimator that applies: a model without rows is exact at every vertex.
inline fiber::Estimator estimator_of(const RenderSettings& settings) {
  return fiber::find_model(settings.model)->has_rows() ? settings.estimator : fiber::Estimator::exact;
}

/// The place of the checkpoint. settings.checkpoint must be set.
inline std::filesystem::path checkpoint_file(const RenderSettings& settings) {
  std::filesystem::path file = *settings.checkpoint;
  return file.empty() ? std::filesystem::path(settings.output).replace_extension(".checkpoint") : file;
}

/// The samples of a pixel to render: from the first, to the second excluded.
struct SampleRange {
  int from = 0, to = 0;
};
inline SampleRange samples_of(const RenderSettings& settings, const scene::Scene& scene) {
  return {settings.samples_from.value_or(0), settings.samples_to.value_or(settings.stop.samples(scene.image.samples))};
}

}  // namespace tress::cli
