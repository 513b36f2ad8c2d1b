// One render without files, console or signals: the scene, its service and its model, pass by pass.
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

/// Has the options of tress render under the same names; every default is that of the program.
struct RenderRequest {
  std::optional<std::string> model;       ///< unset: the model for the scene's materials, fiber::default_model()
  std::vector<fiber::AskedOption> asked;  ///< options that the model must support
  fiber::Estimator estimator = fiber::Estimator::fitted;
  integrate::RenderOptions render;  ///< samples and what Scene::integrator has come from the scene
  adaptive::Options table;
  std::optional<double> noise;    ///< stops once the picture has at most this noise
  std::optional<double> seconds;  ///< stops before a pass that would end later
  std::optional<int> threads;     ///< unset: one per hardware thread that the process may use
  /// Empty: none. "default": adaptive::default_cache_folder(), which may use cache_limit bytes, by default 2^30.
  std::filesystem::path warm_cache;
  std::optional<std::uint64_t> cache_limit;
  bool denoise = false;               ///< adds the layer `denoised`; `noise` then limits what is left
  std::string cache_mode = "append";  ///< one of append, frozen, scratch, require
};

struct RenderOutcome {
  integrate::RenderResult result;
  std::string stopped_by = "samples";    ///< one of "samples", "noise", "time", "caller"
  double noise = 0, bias_bound = 0;      ///< after the last pass
  std::optional<double> denoised_noise;  ///< noise after filtering; unset: not requested, or it failed
  double seconds = 0;                    ///< wall time of everything
  std::string cache_hash;                ///< hash of the table at the end; empty without a table
  std::string cache = "not asked";       ///< "loaded", "absent", "refused: why"; after a save "saved", "merged"
  std::vector<std::string> warnings;
  std::string model, estimator;  ///< the ones that were used
  double epsilon = 0;
};

/// Renders with request.threads. on_pass: called after each pass; if it returns false, the render ends there. Saves the
/// warm cache however it ends. Error if values contradict each other, if a required cache cannot be used, or if one
/// cannot be saved.
Result<RenderOutcome> render_scene(const scene::Scene& scene, const RenderRequest& request,
                                   const std::atomic<bool>& stop,
                                   const std::function<bool(const integrate::PassProgress&)>& on_pass);

}  // namespace tress::python
