// One render without files, console or signals: the scene, the service and the model of it, pass by pass.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "integrate/renderer.h"
#include "models/model_options.h"
#include "scene/model/scene.h"
#include "tress/adaptive/options.h"
#include "tress/fiber/elliptical_model.h"

namespace tress::python {

/// Of the options of tress render those of the same names; every default is that of the program.
struct RenderRequest {
  std::optional<std::string> model;       ///< unset: that of the scene's materials, fiber::default_model()
  std::vector<fiber::AskedOption> asked;  ///< options that the model must have
  fiber::Estimator estimator = fiber::Estimator::fitted;
  integrate::RenderOptions render;              ///< samples come from the scene, roulette from below
  std::optional<integrate::Roulette> roulette;  ///< unset: learned where rows learn, else throughput
  adaptive::Options table;
  std::optional<double> noise;    ///< ends once the picture has as little
  std::optional<double> seconds;  ///< ends before the pass that would end later
  std::optional<int> threads;     ///< unset: one per hardware thread that the process may use
  /// Empty: none; "default": adaptive::default_cache_folder(), which may hold cache_limit bytes, 2^30 unless told.
  std::filesystem::path warm_cache;
  std::optional<std::uint64_t> cache_limit;
  bool denoise = false;               ///< the picture has the layer `denoised`; `noise` is then what is left
  std::string cache_mode = "append";  ///< append, frozen, scratch, require
};

struct RenderOutcome {
  integrate::RenderResult result;
  std::string stopped_by = "samples";    ///< or "noise", "time", "caller"
  double noise = 0, bias_bound = 0;      ///< after the last pass
  std::optional<double> denoised_noise;  ///< what is left of it once filtered; unset: not asked, or it could not be
  double seconds = 0;                    ///< wall time, all in all
  std::string cache_hash;                ///< of the table at the end; empty without one
  std::string cache = "not asked";       ///< "loaded", "absent", "refused: why"; once saved "saved", "merged"
  std::vector<std::string> warnings;
  std::string model, estimator;  ///< that were in use
  double epsilon = 0;
};

/// Renders on so many threads. on_pass: after each pass; false ends the render there. Saves the warm cache whatever
/// ends it. Error of values that contradict each other, of a cache that is required, and of one that cannot be saved.
Result<RenderOutcome> render_scene(const scene::Scene& scene, const RenderRequest& request,
                                   const std::atomic<bool>& stop,
                                   const std::function<bool(const integrate::PassProgress&)>& on_pass);

}  // namespace tress::python
