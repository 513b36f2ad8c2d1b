// What `tress render` was asked for: the only thing that the command line gives to the render.
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

/// What the names of the layers of light groups begin with.
inline constexpr std::string_view light_layer = "light.";
/// The word of --layers for integrate::half_layers.
inline constexpr std::string_view half_pictures = "half";

/// Every value in range: the command line has been checked.
struct RenderSettings {
  std::filesystem::path scene, output;  ///< output ends in .exr; a .png is written beside it
  std::string command;                  ///< as a shell takes it
  image::Precision precision = image::Precision::half;
  std::optional<std::vector<std::string>> layers;  ///< beside beauty; unset: all
  bool keeps_halves = false;                       ///< integrate::half_layers are written
  bool denoise = false;                            ///< filtered at the end; `render` has halves then
  scene::Overrides overrides;
  integrate::RenderOptions render;              ///< samples come from the scene and its overrides, roulette from below
  std::optional<integrate::Roulette> roulette;  ///< unset: learned where rows learn, else throughput
  StopRule stop;                                ///< instead of those samples
  std::optional<bool> adaptive;                 ///< unset: where `stop` ends the render by noise or time
  std::optional<int> threads;                   ///< unset: one per hardware thread that the process may use
  std::string model{fiber::usual_model};        ///< of fiber::models()
  bool model_of_scene = false;                  ///< no --model: that of the scene's materials
  std::vector<fiber::AskedOption> asked;        ///< options that the model must have
  std::optional<int> quadrature_points;         ///< of models that have them
  fiber::Estimator estimator = fiber::Estimator::fitted;
  adaptive::Options table;
  std::optional<float> audited_share;  ///< of the samples, whose bias is measured
  std::optional<std::filesystem::path> warm_cache;
  CacheMode cache_mode = CacheMode::append;
  std::uint64_t cache_limit = std::uint64_t{1} << 30;  ///< bytes, of default_cache
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
  std::optional<std::string> display_server;        ///< HOST:PORT of a viewer
  std::optional<std::string> serve;                 ///< of the live page: ADDRESS:PORT, empty for a free one
  std::optional<std::filesystem::path> serve_reference;
};

/// A model without rows is what it is at every vertex.
inline fiber::Estimator estimator_of(const RenderSettings& settings) {
  return fiber::find_model(settings.model)->has_rows() ? settings.estimator : fiber::Estimator::exact;
}

/// Where the checkpoint is written. settings.checkpoint must be set.
inline std::filesystem::path checkpoint_file(const RenderSettings& settings) {
  std::filesystem::path file = *settings.checkpoint;
  return file.empty() ? std::filesystem::path(settings.output).replace_extension(".checkpoint") : file;
}

/// Samples of a pixel that are taken: from the first, to the second excluded.
struct SampleRange {
  int from = 0, to = 0;
};
inline SampleRange samples_of(const RenderSettings& settings, const scene::Scene& scene) {
  return {settings.samples_from.value_or(0), settings.samples_to.value_or(settings.stop.samples(scene.image.samples))};
}

}  // namespace tress::cli
