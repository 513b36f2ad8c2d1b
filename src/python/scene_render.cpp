#include "python/scene_render.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <system_error>

#include "base/nearest_word.h"
#include "denoise/denoised_layer.h"
#include "geometry/fiber_scene.h"
#include "integrate/camera_projection.h"
#include "integrate/film.h"
#include "integrate/filtered_noise.h"
#include "integrate/stop_rule.h"
#include "models/catalog.h"
#include "models/default_model.h"
#include "python/names.h"
#include "tress/adaptive/cache.h"
#include "tress/adaptive/cache_folder.h"

namespace tress::python {
namespace {

using Clock = std::chrono::steady_clock;

std::optional<Error> contradiction(const scene::Scene& scene, const RenderRequest& request,
                                   const fiber::ModelInfo& info) {
  const auto& crop = request.render.crop;
  if (crop && (crop->left < 0 || crop->top < 0 || crop->width < 1 || crop->height < 1 ||
               crop->left + crop->width > scene.image.width || crop->top + crop->height > scene.image.height))
    return Error{
        "", "crop", fmt::format("pixels within {} x {}", scene.image.width, scene.image.height),
        fmt::format("{}, {}, {}, {}", crop->left, crop->top, crop->left + crop->width, crop->top + crop->height)};
  if (request.cache_limit && request.warm_cache != "default")
    return Error{"", "cache_limit", "warm_cache \"default\"", "\"" + request.warm_cache.string() + "\""};
  if (request.noise && request.seconds) return Error{"", "noise", "one of noise, seconds", "both"};
  if (request.denoise && !request.noise && !request.seconds && scene.image.samples < denoise::least_samples)
    return Error{"", "denoise", fmt::format("{} samples a pixel at least", denoise::least_samples),
                 std::to_string(scene.image.samples)};
  if (const auto refused = fiber::refused(request.asked, info))
    return Error{"", refused->name, refused->expected,
                 fmt::format("{}{}: give model={}, or leave it away", info.name,
                             request.model ? "" : ", the model of the scene's materials", refused->remedy)};
  if (scene.integrator.learns_deep_light() && !scene::light_groups(scene).empty())
    return Error{"", "deep_light", "traced in a scene whose lights have a group", "learned"};
  const std::vector<std::string> modes{"append", "frozen", "scratch", "require"};
  if (std::ranges::find(modes, request.cache_mode) == modes.end())
    return Error{"", "cache_mode", "one of append, frozen, scratch, require", "\"" + request.cache_mode + "\""};
  return std::nullopt;
}

/// The table's file: read before the first pass, and merged with what was learned after the last one.
class CacheFileOf {
 public:
  CacheFileOf(const RenderRequest& request, std::string model) : request_(request), model_(std::move(model)) {}

  /// Call it before the others. Error if the folder of warm_cache "default" cannot be found.
  std::optional<Error> find() {
    if (request_.warm_cache != "default") return std::nullopt;
    const auto folder = adaptive::default_cache_folder();
    if (!folder) return folder.error();
    folder_.emplace(*folder);
    return request_.cache_mode == "frozen" ? std::nullopt : folder_->check();
  }

  std::optional<Error> open(adaptive::Service& service, RenderOutcome* outcome) {
    if (request_.cache_mode == "scratch") return std::nullopt;
    std::error_code unknown;
    const bool must = request_.cache_mode == "require";
    if (folder_) return open_folder(service, must, outcome);
    if (!std::filesystem::exists(request_.warm_cache, unknown)) {
      outcome->cache = "absent";
      if (must) return Error{request_.warm_cache.string(), "", "a warm cache", "no such file"};
      return std::nullopt;
    }
    const auto file = adaptive::CacheFile::open(request_.warm_cache, model_);
    std::optional<Error> error;
    if (file)
      error = service.load(**file);
    else
      error = file.error();
    if (error && error->file.empty()) error->file = request_.warm_cache.string();
    if (error && must) return error;
    refused_ = error.has_value();
    outcome->cache = error ? "refused: " + error->message() : "loaded";
    if (error) outcome->warnings.push_back("warm cache, left as it is: " + error->message());
    // The same as in the program: a frozen table answers every picture alike.
    if (!error && request_.cache_mode == "frozen") service.set_learning(false);
    return std::nullopt;
  }

  std::optional<Error> save(const adaptive::Service& service, RenderOutcome* outcome) {
    if (refused_ || request_.cache_mode == "frozen") return std::nullopt;
    if (folder_) return save_folder(service, outcome);
    if (request_.cache_mode == "scratch") {
      const auto saved = adaptive::replace_cache(request_.warm_cache, *service.rows());
      if (!saved) return saved.error();
      outcome->cache = "saved";
      return std::nullopt;
    }
    const auto saved = adaptive::merge_into_cache(request_.warm_cache, *service.rows());
    if (!saved) return saved.error();
    outcome->cache = saved->refusal ? "refused: " + saved->refusal->message() : "merged";
    return std::nullopt;
  }

 private:
  std::optional<Error> open_folder(adaptive::Service& service, bool must, RenderOutcome* outcome) {
    const adaptive::CacheFolder::Loaded found = folder_->load(service);
    for (const Error& refused : found.refused) {
      if (must) return refused;
      outcome->warnings.push_back("warm cache, left as it is: " + refused.message());
    }
    if (found.files == 0 && must)
      return Error{folder_->folder().string(), "", "what was learned of a fiber of this scene", "none"};
    outcome->cache = found.files > 0 ? "loaded" : "absent";
    if (found.files > 0 && request_.cache_mode == "frozen") service.set_learning(false);
    return std::nullopt;
  }

  std::optional<Error> save_folder(const adaptive::Service& service, RenderOutcome* outcome) {
    const auto saved = folder_->save(service, request_.cache_mode == "scratch");
    if (!saved) return saved.error();
    for (const Error& refused : saved->refused)
      outcome->warnings.push_back("warm cache, not saved: " + refused.message());
    outcome->cache = request_.cache_mode == "scratch" ? "saved" : "merged";
    const auto pruned = folder_->prune(request_.cache_limit.value_or(std::uint64_t{1} << 30));
    return pruned ? std::nullopt : std::optional<Error>(pruned.error());
  }

  const RenderRequest& request_;
  std::optional<adaptive::CacheFolder> folder_;
  std::string model_;
  bool refused_ = false;
};

/// Filters the picture. If that fails it logs a warning, and the picture stays as it was rendered.
void filter(RenderOutcome* outcome) {
  image::Picture* picture = &outcome->result.picture;
  const auto found = denoise::add_denoised("", picture);
  integrate::remove_halves(picture);
  if (found)
    outcome->denoised_noise = found->noise();
  else
    outcome->warnings.push_back("not denoised: " + found.error().message());
}

std::string model_of(const scene::Scene& scene) {
  std::vector<fiber::FiberParameters> materials;
  for (const scene::Material& material : scene.materials) materials.push_back(material.fiber);
  return fiber::default_model(materials, scene.fibers).info->name;
}

Result<RenderOutcome> rendered(const scene::Scene& scene, const RenderRequest& request, const fiber::ModelInfo& info,
                               const std::atomic<bool>& stop,
                               const std::function<bool(const integrate::PassProgress&)>& on_pass) {
  const Clock::time_point start = Clock::now();
  const auto elapsed = [&] { return std::chrono::duration<double>(Clock::now() - start).count(); };
  RenderOutcome outcome;
  fiber::ModelService learned;
  const bool has_rows = info.has_rows() && request.estimator != fiber::Estimator::exact;
  const bool is_frozen = !request.warm_cache.empty() && request.cache_mode == "frozen";
  adaptive::Options table = request.table;
  table.seed = request.render.seed;
  if (is_frozen) table.take_rows_as_they_are();
  if (has_rows) learned = fiber::make_service(info, table);
  const std::unique_ptr<fiber::FiberModel> model = info.make({request.estimator, learned.service.get(), 0});
  std::vector<fiber::FiberId> fibers;
  for (const fiber::FiberParameters& parameters : scene.fibers) fibers.push_back(model->add_fiber(parameters));
  std::optional<CacheFileOf> cache;
  if (has_rows && !request.warm_cache.empty()) {
    cache.emplace(request, learned.target->model_name());
    if (auto error = cache->find()) return *error;
    if (auto error = cache->open(*learned.service, &outcome)) return *error;
  } else if (!request.warm_cache.empty()) {
    outcome.warnings.push_back(fmt::format(
        "warm cache {}: not used and left as it is, {}", request.warm_cache.string(),
        info.has_rows() ? "the exact estimator has no rows" : fmt::format("model {} has no rows", info.name)));
  }
  integrate::RenderOptions options = request.render;
  integrate::StopRule rule{request.seconds, request.noise};
  if (request.table.picture_error > 0) rule.picture_error = request.table.picture_error;
  options.samples = rule.samples(scene.image.samples);
  options.adaptive = scene.integrator.adaptive.value_or(request.noise || request.seconds);
  integrate::set_asked(scene.integrator, has_rows && !is_frozen, &options);
  if (!model->evaluates() && !model->estimates()) options.light_samples = 0;
  options.halves = request.denoise;
  const geometry::FiberScene strands(scene);
  if (!fiber::has(info, fiber::Asks::samples)) options.near.where = integrate::NearOptions::Where::nowhere;
  integrate::measure_needs(options.near, scene, strands);
  std::optional<integrate::FilteredNoise> filtered;
  if (request.denoise && request.noise) filtered.emplace(*request.noise, scene);
  outcome.result = integrate::render(scene, strands, *model, fibers, learned.service.get(), options, stop,
                                     [&](const integrate::PassProgress& pass) {
                                       outcome.noise = pass.noise;
                                       outcome.bias_bound = pass.table.bias_bound;
                                       const double noise = filtered ? filtered->after(pass) : pass.noise;
                                       const char* end = rule.reason_to_end(pass, noise, elapsed());
                                       if (end != nullptr) outcome.stopped_by = end;
                                       const bool goes_on = on_pass(pass);
                                       if (!goes_on) outcome.stopped_by = "caller";
                                       return goes_on && end == nullptr;
                                     });
  if (outcome.result.interrupted) outcome.stopped_by = "caller";
  integrate::describe_camera(scene.camera, scene.image, &outcome.result.picture, scene.origin);
  if (request.denoise) filter(&outcome);
  if (learned.service) outcome.cache_hash = adaptive::cache_hash(*learned.service->rows());
  if (cache) {
    if (auto error = cache->save(*learned.service, &outcome)) return *error;
  }
  outcome.model = info.name;
  outcome.estimator = fiber::estimator_name(info.has_rows() ? request.estimator : fiber::Estimator::exact);
  outcome.epsilon = info.epsilon(table);
  outcome.seconds = elapsed();
  return outcome;
}

}  // namespace

Result<RenderOutcome> render_scene(const scene::Scene& scene, const RenderRequest& request,
                                   const std::atomic<bool>& stop,
                                   const std::function<bool(const integrate::PassProgress&)>& on_pass) {
  const std::string model = request.model ? *request.model : model_of(scene);
  const fiber::ModelInfo* info = fiber::find_model(model);
  if (info == nullptr) return unknown_model(model);
  if (auto error = contradiction(scene, request, *info)) return *error;
  const int threads = request.threads.value_or(tbb::info::default_concurrency());
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  return arena.execute([&] { return rendered(scene, request, *info, stop, on_pass); });
}

}  // namespace tress::python
