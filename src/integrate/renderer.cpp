#include "integrate/renderer.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <chrono>
#include <cmath>
#include <cstring>
#include <ctime>
#include <utility>

#include "base/cpu_clock.h"
#include "base/denormals.h"
#include "integrate/bias_audit.h"
#include "integrate/cryptomatte.h"
#include "integrate/deeper_light.h"
#include "integrate/film.h"
#include "integrate/heatmap.h"
#include "integrate/pass_order.h"
#include "integrate/path_tracer.h"
#include "integrate/possible_light.h"
#include "integrate/sample_plan.h"
#include "integrate/spread_pixels.h"

namespace tress::integrate {
namespace {

constexpr int block_size = 16;  ///< pixels along the side of a task's block

/// CPU time of all threads of this process, seconds.
double process_cpu_seconds() {
  std::timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Number of blocks along a side of `length` pixels.
int blocks_along(int length) { return (length + block_size - 1) / block_size; }

struct PathCount {
  std::uint64_t paths = 0;
  std::uint64_t covered = 0;  ///< paths that met something
  std::uint64_t dropped = 0;  ///< paths that were not finite
};

/// Samples the pixels of a pass that lie in one block, in order.
PathCount render_block(const PathTracer& tracer, BiasAuditor* auditor, int block, int pass, std::uint32_t first_sample,
                       SamplePlan& plan, Film& film) {
  const FlushDenormals flush;
  const image::Window& window = film.window();
  const int blocks_across = blocks_along(window.width);
  const int left = window.left + block % blocks_across * block_size;
  const int top = window.top + block / blocks_across * block_size;
  const int right = std::min(left + block_size, window.left + window.width);
  const int bottom = std::min(top + block_size, window.top + window.height);
  PathCount count;
  double time = film.timed() ? thread_cpu_seconds() : 0;
  for (int y = top; y < bottom; ++y) {
    for (int x = left; x < right; ++x) {
      const std::uint32_t end = plan.samples_after(pass, x, y);
      for (std::uint32_t count_of_pixel = film.pixel(x, y).traced(); count_of_pixel < end; ++count_of_pixel) {
        const std::uint32_t sample = first_sample + count_of_pixel;
        const PathSums path = tracer.trace(x, y, sample);
        count.dropped += film.add(x, y, path) ? 0 : 1;
        plan.note(x, y, film.pixel(x, y));
        ++count.paths;
        count.covered += path.coverage > 0 ? 1 : 0;
        if (auditor != nullptr) auditor->audit(x, y, sample);
        if (!film.timed()) continue;
        const double start = std::exchange(time, thread_cpu_seconds());
        film.add_time(x, y, time - start);
      }
    }
  }
  return count;
}

/// Samples the pixels of a pass. One task samples each block, and a pass ends before the next begins, so sums are added
/// in the order of the samples for any number of threads.
PathCount render_pass(const PathTracer& tracer, BiasAuditor* auditor, int pass, std::uint32_t first_sample,
                      const std::atomic<bool>& stop, SamplePlan& plan, Film& film) {
  const int blocks = blocks_along(film.window().width) * blocks_along(film.window().height);
  std::atomic<std::uint64_t> traced{0}, covered{0}, dropped{0};
  tbb::parallel_for(0, blocks, [&](int block) {
    if (stop.load(std::memory_order_relaxed)) return;
    const PathCount count = render_block(tracer, auditor, block, pass, first_sample, plan, film);
    traced += count.paths;
    covered += count.covered;
    dropped += count.dropped;
  });
  return {traced, covered, dropped};
}

struct Brightness {
  float mean = 0;  ///< mean of hair and surfaces over channels; 0 if they are black or were not found
  std::uint64_t paths = 0;
};

/// Measures the brightness by a few paths spread over the whole image, so that it is the same for every crop. It only
/// scales a roulette and need not be precise.
Brightness measured_brightness(const PathTracer& tracer, const scene::Image& image, const std::atomic<bool>& stop) {
  constexpr std::uint64_t enough = 128, most_rays = 2048;
  constexpr std::uint32_t own_sample = 1u << 31;  // an index that no picture uses
  const FlushDenormals flush;
  const std::uint64_t rays =
      std::min(most_rays, static_cast<std::uint64_t>(image.width) * static_cast<std::uint64_t>(image.height));
  Brightness found;
  double sum = 0;
  for (std::uint64_t i = 0; i < rays && found.paths < enough && !stop; ++i) {
    const glm::ivec2 pixel = spread_pixel(i, image);
    const PathSums path = tracer.trace(pixel.x, pixel.y, own_sample);
    if (!(path.coverage > 0) || !path.is_finite()) continue;
    const glm::vec3 light = path.beauty() - path.layers[background_layer];
    sum += static_cast<double>(light.x + light.y + light.z) / 3;
    ++found.paths;
  }
  if (sum > 0) found.mean = static_cast<float>(sum / static_cast<double>(found.paths));
  return found;
}

/// The brightness that a saved render measured; mean is -1 if the state does not have it.
Brightness saved_brightness(const RenderState& state) {
  Brightness brightness{-1, 0};
  const auto found = state.sections.find("pilot");
  if (found == state.sections.end() || found->second.size() != sizeof(float)) return brightness;
  std::memcpy(&brightness.mean, found->second.data(), sizeof(float));
  return std::isfinite(brightness.mean) ? brightness : Brightness{-1, 0};
}

DeeperLight::PictureSoFar picture_so_far(const Film& film) {
  double pixels = 0, samples = 0, hits = 0, mean = 0, variance = 0, degrees = 0;
  const image::Window& window = film.window();
  for (int y = window.top; y < window.top + window.height; ++y) {
    for (int x = window.left; x < window.left + window.width; ++x) {
      const PixelSums& pixel = film.pixel(x, y);
      if (!(pixel.coverage > 0)) continue;
      const glm::dvec3 light = pixel.beauty(), squares = pixel.squared_deviations;
      ++pixels;
      samples += pixel.samples;
      hits += static_cast<double>(pixel.vertices);
      mean += (light.x + light.y + light.z) / (3 * static_cast<double>(pixel.samples));
      variance += (squares.x + squares.y + squares.z) / 3;
      degrees += pixel.samples - 1;
    }
  }
  if (!(pixels > 0)) return {};
  return {mean / pixels, degrees > 0 ? variance / degrees : 0, 1 + hits / samples};
}

bool splits_glint(const scene::Scene& scene) {
  return std::any_of(scene.fibers.begin(), scene.fibers.end(),
                     [](const fiber::FiberParameters& fiber) { return fiber.split_glint; });
}

Film::Extra extra_layers(const scene::Scene& scene, const RenderOptions& options) {
  Film::Extra extra;
  extra.first_sample = static_cast<std::uint32_t>(options.first_sample);
  extra.halves = options.halves;
  extra.data = options.data;
  extra.deep_light = options.deep_light == DeepLight::learned;
  extra.depth_bins = options.deep;
  extra.emission =
      std::any_of(scene.lights.begin(), scene.lights.end(), [](const scene::Light& light) { return light.visible; });
  extra.groups = scene::light_groups(scene);
  extra.backdrop_group = scene::group_index(extra.groups, scene.environment_group);
  return extra;
}

[[maybe_unused]] bool is_within(const image::Window& part, const image::Window& whole) {
  return part.width >= 1 && part.height >= 1 && part.left >= 0 && part.top >= 0 &&
         part.left <= whole.width - part.width && part.top <= whole.height - part.height;
}

bool restored(const RenderState& state, DeeperLight& deeper) {
  const auto found = state.sections.find("deeper");
  return found != state.sections.end() && deeper.set_state(found->second);
}

/// Updates `deeper` after a pass, if there are enough new paths.
void learn_deeper(const Film& film, DeeperLight& deeper, PassProgress& progress) {
  const double start = thread_cpu_seconds();
  if (deeper.is_due(progress.paths_so_far)) deeper.update(picture_so_far(film), progress.paths_so_far);
  progress.deeper = {deeper.place_count(), deeper.noted(), deeper.bytes(), thread_cpu_seconds() - start};
}

}  // namespace

void set_asked(const scene::Integrator& asked, bool rows_learn, RenderOptions* options) {
  options->max_depth = asked.max_depth.value_or(options->max_depth);
  options->light_samples = asked.light_samples.value_or(options->light_samples);
  options->bcsdf_samples = asked.bcsdf_samples.value_or(options->bcsdf_samples);
  options->deep_light = asked.learns_deep_light() ? DeepLight::learned : DeepLight::traced;
  options->deep_light_depth = asked.deep_light_depth.value_or(options->deep_light_depth);
  const bool learns = asked.roulette ? asked.roulette == "learned" : rows_learn || asked.learns_deep_light();
  options->roulette = learns ? Roulette::learned : Roulette::throughput;
  set_asked(asked, &options->near);
}

RenderResult render(const scene::Scene& scene, const geometry::FiberScene& fibers, fiber::FiberModel& model,
                    const std::vector<fiber::FiberId>& fiber_ids, adaptive::Service* service,
                    const RenderOptions& options, const std::atomic<bool>& stop,
                    const std::function<bool(const PassProgress&)>& on_pass) {
  assert(options.samples >= 1 && options.light_samples >= 0 && options.bcsdf_samples >= 1 && options.max_depth >= 1);
  assert(fiber_ids.size() == scene.fibers.size());
  assert(
      options.deep_light == DeepLight::traced ||
      (options.roulette == Roulette::learned && options.deep_light_depth >= 2 && scene::light_groups(scene).empty()));
  std::optional<DeeperLight> deeper;
  if (options.roulette == Roulette::learned) deeper.emplace(scene, options.deep_light == DeepLight::learned);
  const double pilot_start = process_cpu_seconds();
  if (service) service->prepare();
  const PathTracer plain(scene, fibers, model, fiber_ids, options, deeper ? &*deeper : nullptr);
  const Brightness brightness = options.resume != nullptr ? saved_brightness(*options.resume)
                                : options.shadow_roulette && options.light_samples > 0
                                    ? measured_brightness(plain, scene.image, stop)
                                    : Brightness{};
  PathTracer tracer = plain.at_brightness(brightness.mean);
  const double pilot_cpu_seconds = process_cpu_seconds() - pilot_start;
  const image::Window whole{0, 0, scene.image.width, scene.image.height};
  const bool opaque = scene.environment_visible && !scene.image.transparent;
  Film film(options.crop.value_or(whole), splits_glint(scene), options.heatmap,
            opaque ? Ground::backdrop : Ground::nothing, options.mattes ? scene.grooms.size() + scene.meshes.size() : 0,
            scene.next.has_value(), extra_layers(scene, options));
  assert(is_within(film.window(), whole));
  std::optional<BiasAuditor> auditor;
  if (options.audit != nullptr) auditor.emplace(*options.audit, scene, fibers, options, brightness.mean, film.window());
  const PossibleLight possible = possible_light(scene, fibers, model, fiber_ids, options.light_samples);
  SamplePlan plan(film.window(), options.adaptive, possible);
  RenderResult result;
  PassProgress progress;
  progress.film = &film;
  progress.pass_count = pass_count(options.samples);
  progress.paths_total = static_cast<std::uint64_t>(film.window().width) *
                         static_cast<std::uint64_t>(film.window().height) * static_cast<std::uint64_t>(options.samples);
  std::string deeper_state;
  progress.sections = [&] {
    auto all = film.sections();
    all.emplace_back("pilot", std::string_view(reinterpret_cast<const char*>(&brightness.mean), sizeof(float)));
    if (auditor) all.push_back(auditor->section());
    plan.add_sections(&all);
    if (deeper) all.emplace_back("deeper", deeper_state = deeper->state());
    return all;
  };
  const auto set_excess = [&] {
    progress.deep_light = film.deep_light_bias();
    if (auditor) progress.bias = auditor->measured(film);
    if (!model.tells_excess()) return;
    progress.excess = film.excess();
    tracer.set_brightness(film.brightness());
  };
  if (options.resume != nullptr) {
    const RenderState& state = *options.resume;
    result.unusable = !(brightness.mean >= 0) || state.passes < 0 || state.passes > progress.pass_count ||
                      !film.set_sections(state.sections) || !plan.set_sections(state.sections) ||
                      (auditor && !auditor->set_section(state.sections)) || (deeper && !restored(state, *deeper));
    if (result.unusable) return result;
    result.passes = state.passes;
    progress.paths_so_far = state.paths;
    set_excess();
  }
  for (int pass = result.passes; pass < progress.pass_count && !stop; ++pass) {
    const auto start = std::chrono::steady_clock::now();
    const double cpu_start = process_cpu_seconds();
    progress.pass = pass;
    const PathCount paths = render_pass(tracer, auditor ? &*auditor : nullptr, pass,
                                        static_cast<std::uint32_t>(options.first_sample), stop, plan, film);
    progress.pixels = paths.paths;
    progress.dropped_samples = paths.dropped;
    progress.paths_so_far += progress.pixels;
    if (service) progress.table = service->publish(paths.covered + (pass == 0 ? brightness.paths : 0));
    if (deeper) learn_deeper(film, *deeper, progress);
    progress.cpu_seconds = process_cpu_seconds() - cpu_start + (pass == 0 ? pilot_cpu_seconds : 0);
    progress.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    set_noise(film, possible, progress);
    set_excess();
    result.passes = pass + 1;
    if (!stop) plan.pass_ended(pass);
    // The passes of an adaptive picture are rounded to whole samples, so the planned total may be off.
    if (!stop && result.passes == progress.pass_count) progress.paths_total = progress.paths_so_far;
    if (on_pass && !on_pass(progress)) break;
  }
  result.interrupted = stop && progress.paths_so_far < progress.paths_total;
  const auto placed = [&](image::Picture picture) {
    picture.whole_width = whole.width;
    picture.whole_height = whole.height;
    return picture;
  };
  result.picture = placed(film.picture());
  if (options.mattes) {
    for (const MatteKind& kind : matte_kinds(scene)) add_mattes(film, kind, &result.picture);
  }
  add_strand_mattes(film, &result.picture);
  result.bias = progress.bias;
  result.excess = progress.excess;
  result.deep_light = progress.deep_light;
  if (options.deep) result.deep = film.deep_picture();
  if (options.heatmap) result.heatmap = placed(heatmap(film.costs(), film.window()));
  result.samples_per_pixel = film.samples_per_pixel();
  result.queries = film.queries();
  result.exact_queries = film.exact_queries();
  result.dropped_samples = film.dropped_samples();
  return result;
}

}  // namespace tress::integrate
