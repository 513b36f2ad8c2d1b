// Progressive path tracing of hair: passes, film, layers.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "geometry/fiber_scene.h"
#include "image/picture.h"
#include "integrate/film.h"
#include "scene/model/scene.h"
#include "tress/adaptive/service.h"
#include "tress/fiber/fiber_model.h"

namespace tress::integrate {

/// Which samples are traced a second time, and by what.
struct BiasAudit {
  const fiber::FiberModel* unbiased = nullptr;  ///< outlives the render
  std::vector<fiber::FiberId> fiber_ids;        ///< what it calls each of scene.fibers
  float share = 0.01f;                          ///< of the samples, (0, 1]
};

/// Relative to the mean luminance of what the audited pixels show of hair and surfaces; backgrounds are not in it.
struct MeasuredBias {
  double value = 0;  ///< picture over truth, minus 1
  double error = 0;  ///< its standard error
  std::uint64_t paths = 0;
};

/// What ends a path, or lets several go on from a hit; no rule changes the mean. throughput: the root of what a path
/// has lost; learned: the light that comes after a hit, learned from earlier passes (DeeperLight).
enum class Roulette { throughput, learned };
/// What a hit brings from whose place enough light is known (DeeperLight). traced: what paths from there find. learned:
/// the mean of what earlier passes found, from RenderOptions::deep_light_depth on: the path ends there. Biased by what
/// is wrong in that, which is told by paths that are followed all the same.
enum class DeepLight { traced, learned };

/// `asked`, else learned where rows learn, or deep light does: where nothing else learns neither does this, so that
/// parts of a picture fit together.
inline Roulette roulette_or_usual(const std::optional<Roulette>& asked, bool rows_learn, DeepLight deep_light) {
  return asked.value_or(rows_learn || deep_light == DeepLight::learned ? Roulette::learned : Roulette::throughput);
}

/// Where a render goes on: what had been done when it was saved, after a pass.
struct RenderState {
  int passes = 0;
  std::uint64_t paths = 0;                      ///< PassProgress::paths_so_far
  std::map<std::string, std::string> sections;  ///< PassProgress::sections()
};

struct RenderOptions {
  int samples = 64;       ///< per pixel
  int first_sample = 0;   ///< index of the first of them, where others render those before it
  int light_samples = 2;  ///< at the first hit, over all lights; 1 at later ones; 0: none at any hit
  int bcsdf_samples = 1;  ///< at the first hit, each going on as a path; 1 at later ones
  int max_depth = 256;    ///< hits of a path, on fibers and surfaces
  Roulette roulette = Roulette::learned;
  int roulette_depth = 4;                    ///< by throughput, and until enough is learned: from this hit on
  DeepLight deep_light = DeepLight::traced;  ///< learned: with Roulette::learned, in a scene without light groups
  int deep_light_depth = 3;                  ///< 2 at least: the first hit is never answered
  bool shadow_roulette = true;               ///< light samples that bring little are traced in part only (PathTracer)
  /// More samples where the picture is noisier (SamplePlan). What a crop shows is then not bit for bit the whole's.
  bool adaptive = false;
  std::uint64_t seed = 0;
  /// Pixels that are rendered, inside the image; unset: all. A pixel's paths are the same whatever is rendered beside
  /// it, under Roulette::throughput; what they learn is not.
  std::optional<image::Window> crop;
  bool mattes = false;   ///< the picture has the layers of cryptomatte.h
  bool halves = false;   ///< the picture has half_layers
  DataLayers data;       ///< the picture has these
  bool heatmap = false;  ///< time every path, for RenderResult::heatmap
  /// Measures the bias of the picture on some of its samples, for RenderResult::bias; null: not. Outlives the render.
  const BiasAudit* audit = nullptr;
  /// First hits on fibers that are seen wider than this, in pixels, are traced from where the ray met the fiber, a
  /// share of them that rises evenly to all at twice the width, so that no edge shows. 0: none.
  float near_pixels = 0;
  /// Of a render with the same scene and options, whose service has been restored to the same pass; null: from the
  /// start. Outlives the call.
  const RenderState* resume = nullptr;
};

/// What is known of the light after a hit; zeros under Roulette::throughput.
struct DeeperProgress {
  std::uint64_t places = 0;  ///< cells of place and direction
  std::uint64_t copies = 0;  ///< of paths, that the cells have learned from
  std::uint64_t bytes = 0;
  double cpu_seconds = 0;  ///< of this pass, to take in what was noted
};

/// What a pass did, before and after the table was published.
struct PassProgress {
  int pass = 0;  ///< from 0
  int pass_count = 0;
  std::uint64_t pixels = 0;           ///< samples of this pass: of as many pixels, or of some more often
  std::uint64_t dropped_samples = 0;  ///< of them, not finite and not in the picture
  std::uint64_t paths_so_far = 0, paths_total = 0;
  std::optional<Brightening> excess;        ///< of the picture so far; unset where the model tells none
  std::optional<DeepLightBias> deep_light;  ///< of the picture so far; unset under DeepLight::traced
  /// Of the picture so far, relative: Film::relative_noise() and `unmet_noise`. 0: there is no light, or no pixel has
  /// two samples.
  double noise = 0;
  double unmet_noise = 0;      ///< of light that paths may not have met (PossibleLight)
  double light_paths = 0;      ///< Film::Seen::light_paths
  double seconds = 0;          ///< wall time of the pass
  double cpu_seconds = 0;      ///< CPU time of the pass, all threads, learning included
  adaptive::PassReport table;  ///< empty without a service
  DeeperProgress deeper;
  const Film* film = nullptr;  ///< what the paths have brought so far; valid during the call
  /// All that the render is beside its service, by name: good until the call ends.
  std::function<std::vector<std::pair<std::string, std::string_view>>()> sections;
};

struct RenderResult {
  image::Picture picture;                   ///< layers of Film::picture(), mattes; other metadata left to the caller
  std::optional<image::Picture> heatmap;    ///< if asked for
  std::optional<MeasuredBias> bias;         ///< if asked for
  std::optional<Brightening> excess;        ///< of the rows; unset where the model tells none
  std::optional<DeepLightBias> deep_light;  ///< unset under DeepLight::traced
  int passes = 0;
  double samples_per_pixel = 0;
  bool interrupted = false;  ///< by `stop`; not by on_pass
  bool unusable = false;     ///< RenderOptions::resume is of another render: nothing was rendered
  std::uint64_t queries = 0, exact_queries = 0;
  std::uint64_t dropped_samples = 0;  ///< not finite and not in the picture (PICTURE.md)
};

/// Renders in the calling oneTBB arena. The same seed gives the same bits for any number of threads.
/// fiber_ids: what `model` calls each of scene.fibers. service: null for `exact`. stop: polled often; the picture so
/// far is then returned, each pixel the mean of the samples it has; one that has none yet shows the nearest that has,
/// or black with A = 0 if there is none. on_pass: after each publish(); returns false to stop there.
RenderResult render(const scene::Scene& scene, const geometry::FiberScene& fibers, fiber::FiberModel& model,
                    const std::vector<fiber::FiberId>& fiber_ids, adaptive::Service* service,
                    const RenderOptions& options, const std::atomic<bool>& stop,
                    const std::function<bool(const PassProgress&)>& on_pass);

}  // namespace tress::integrate
