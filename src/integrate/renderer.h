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
#include "integrate/near_rule.h"
#include "scene/model/scene.h"
#include "tress/adaptive/service.h"
#include "tress/fiber/fiber_model.h"

namespace tress::integrate {

/// Settings for tracing some samples a second time with an unbiased model.
struct BiasAudit {
  const fiber::FiberModel* unbiased = nullptr;  ///< must outlive the render
  std::vector<fiber::FiberId> fiber_ids;        ///< its id for each of scene.fibers
  float share = 0.01f;                          ///< share of the samples that are audited, (0, 1]
};

/// Bias relative to the mean luminance of hair and surfaces in the audited pixels, without backgrounds.
struct MeasuredBias : Brightening {
  std::uint64_t paths = 0;
};

/// The rule that ends a path or splits it at a hit; no rule changes the mean. throughput: by the square root of the
/// path's throughput. learned: by the light that comes after a hit, learned from earlier passes (DeeperLight).
enum class Roulette { throughput, learned };
/// The light of a hit where enough has been learned (DeeperLight). traced: paths go on from there. learned: from
/// RenderOptions::deep_light_depth on, the path ends and takes the mean that earlier passes found. Errors of that mean
/// are a bias, which is measured by paths that are still followed.
enum class DeepLight { traced, learned };

/// The state of a render that was saved after a pass, from which a render goes on.
struct RenderState {
  int passes = 0;
  std::uint64_t paths = 0;                      ///< PassProgress::paths_so_far
  std::map<std::string, std::string> sections;  ///< PassProgress::sections()
};

struct RenderOptions {
  int samples = 64;       ///< samples per pixel
  int first_sample = 0;   ///< index of the first sample, if other renders take those before it
  int light_samples = 2;  ///< number at the first hit, over all lights; later hits have 1; 0: none at any hit
  int bcsdf_samples = 1;  ///< number at the first hit, each goes on as a path; later hits have 1
  int max_depth = 256;    ///< largest number of hits of a path, on fibers and surfaces
  Roulette roulette = Roulette::learned;
  int roulette_depth = 4;  ///< first hit with roulette by throughput, which is used until enough is learned
  DeepLight deep_light = DeepLight::traced;  ///< `learned` needs Roulette::learned and a scene without light groups
  int deep_light_depth = 3;                  ///< at least 2: the first hit never has an answer
  bool shadow_roulette = true;  ///< whether only a share of dim light samples is traced (PathTracer::at_brightness)
  /// Takes more samples where the picture is noisier (SamplePlan). A crop is then not the same to the bit as the whole.
  bool adaptive = false;
  std::uint64_t seed = 0;
  /// Pixels to render, inside the image; all if unset. Under Roulette::throughput, the paths of a pixel do not depend
  /// on which others are rendered, but what they learn does.
  std::optional<image::Window> crop;
  bool mattes = false;   ///< whether the picture has the layers of cryptomatte.h
  bool halves = false;   ///< whether the picture has half_layers
  DataLayers data;       ///< data layers of the picture
  bool heatmap = false;  ///< whether every path is timed, for RenderResult::heatmap
  bool deep = false;     ///< whether light is kept by depth, for RenderResult::deep: 320 bytes a pixel
  /// Measures the bias of the picture on some of its samples, for RenderResult::bias; null for no measurement. It must
  /// outlive the render.
  const BiasAudit* audit = nullptr;
  NearOptions near;  ///< which hits are traced from where the ray met the fiber, if the model can
  /// State of a render with the same scene and options, from which this one goes on; null to start anew. The service
  /// must have been restored to the same pass. It must outlive the call.
  const RenderState* resume = nullptr;
};

/// Sets what a scene asks for. Where it does not name a roulette, it is learned if rows or deep light learn. If nothing
/// else learns, roulette does not learn either, so that separately rendered parts of a picture fit together.
void set_asked(const scene::Integrator& asked, bool rows_learn, RenderOptions* options);

/// Size and cost of DeeperLight; zeros under Roulette::throughput.
struct DeeperProgress {
  std::uint64_t places = 0;  ///< cells of place and direction
  std::uint64_t copies = 0;  ///< copies of paths that the cells have learned from
  std::uint64_t bytes = 0;
  double cpu_seconds = 0;  ///< CPU time of update() after this pass
};

/// Report of a pass, including the publish() after it.
struct PassProgress {
  int pass = 0;  ///< from 0
  int pass_count = 0;
  std::uint64_t pixels = 0;           ///< samples of this pass; an adaptive pass may take several of one pixel
  std::uint64_t dropped_samples = 0;  ///< those of them that were not finite, which the picture leaves out
  std::uint64_t paths_so_far = 0, paths_total = 0;
  std::optional<Brightening> excess;        ///< of the picture so far; unset if the model cannot evaluate it
  std::optional<MeasuredBias> bias;         ///< of the picture so far; unset without RenderOptions::audit
  std::optional<DeepLightBias> deep_light;  ///< of the picture so far; unset under DeepLight::traced
  /// Relative noise of the picture so far: Film::relative_noise() and `unmet_noise` together. 0 if there is no light,
  /// or no pixel has two samples.
  double noise = 0;
  double unmet_noise = 0;      ///< relative noise of light that paths may not have met (PossibleLight)
  double light_paths = 0;      ///< Film::Seen::light_paths
  double seconds = 0;          ///< wall time of the pass
  double cpu_seconds = 0;      ///< CPU time of the pass, all threads, learning included
  adaptive::PassReport table;  ///< empty without a service
  DeeperProgress deeper;
  const Film* film = nullptr;  ///< sums of the paths so far; valid during the call
  /// Returns the whole state of the render except its service, as named bytes, which are valid until the call ends.
  std::function<std::vector<std::pair<std::string, std::string_view>>()> sections;
};

struct RenderResult {
  image::Picture picture;                   ///< layers of Film::picture() and mattes; the caller adds other metadata
  std::optional<image::Picture> heatmap;    ///< set if requested
  std::optional<image::DeepPicture> deep;   ///< Film::deep_picture(), of the window of `picture`; set if requested
  std::optional<MeasuredBias> bias;         ///< set if requested
  std::optional<Brightening> excess;        ///< of the rows; unset if the model cannot evaluate it
  std::optional<DeepLightBias> deep_light;  ///< unset under DeepLight::traced
  int passes = 0;
  double samples_per_pixel = 0;
  bool interrupted = false;  ///< whether `stop` ended the render; false if on_pass did
  bool unusable = false;     ///< RenderOptions::resume is of another render, so nothing was rendered
  std::uint64_t queries = 0, exact_queries = 0;
  std::uint64_t dropped_samples = 0;  ///< samples that were not finite, which the picture leaves out (PICTURE.md)
};

/// Renders in the calling oneTBB arena. The same seed gives the same bits for any number of threads.
/// fiber_ids: the id of `model` for each of scene.fibers. service: null for `exact`. stop: polled often; once it is
/// set, the picture so far is returned, where each pixel is the mean of its samples (Film::picture()). on_pass: called
/// after each publish(); returns false to end the render.
RenderResult render(const scene::Scene& scene, const geometry::FiberScene& fibers, fiber::FiberModel& model,
                    const std::vector<fiber::FiberId>& fiber_ids, adaptive::Service* service,
                    const RenderOptions& options, const std::atomic<bool>& stop,
                    const std::function<bool(const PassProgress&)>& on_pass);

}  // namespace tress::integrate
