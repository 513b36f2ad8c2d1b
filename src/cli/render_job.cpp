#include "cli/render_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <memory>
#include <new>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/checkpoint_session.h"
#include "cli/console.h"
#include "cli/live_look.h"
#include "cli/live_view.h"
#include "cli/model_choice.h"
#include "cli/part_header.h"
#include "cli/picture_files.h"
#include "cli/process.h"
#include "cli/render_checks.h"
#include "cli/render_identity.h"
#include "cli/render_result.h"
#include "cli/render_telemetry.h"
#include "cli/scene_model.h"
#include "geometry/fiber_scene.h"
#include "integrate/filtered_noise.h"

namespace tress::cli {
namespace {

using Clock = std::chrono::steady_clock;

/// The files that are open before a render begins.
struct RenderFiles {
  Identity identity;
  std::optional<CheckpointSession> checkpoint;
  std::optional<SavedRender> saved;  ///< the contents of the checkpoint
  TelemetryLines& telemetry;
  LiveView& live;
  const InterruptGuard& interrupt;
  std::unique_ptr<const geometry::FiberScene> strands;  ///< null: not built yet, or built for another look
};

/// One render, from the loaded scene to the saved files.
class RenderJob {
 public:
  RenderJob(const RenderSettings& settings, const scene::Scene& scene, int threads, Clock::time_point start,
            RenderFiles& files, fiber::ModelService* carried)
      : settings_(settings),
        scene_(scene),
        threads_(threads),
        start_(start),
        telemetry_(settings, files.telemetry),
        fibers_(settings),
        service_(fibers_.service()),
        identity_(files.identity),
        checkpoint_(files.checkpoint ? &*files.checkpoint : nullptr),
        saved_(files.saved ? &*files.saved : nullptr),
        carried_(carried),
        live_(files.live),
        interrupt_(files.interrupt),
        strands_(files.strands) {
    if (settings.warm_cache && service_) {
      cache_.emplace(*settings.warm_cache, settings.cache_mode, fibers_.target_name());
      cache_->set_limit(settings.cache_limit);
    }
  }

  /// Whether run() ended because the page requested another look: nothing is saved then, and what was learned is passed
  /// on.
  bool is_dropped() const { return dropped_; }

  /// Must run inside the arena.
  int run() {
    try {
      return rendered();
    } catch (const std::bad_alloc&) {
      // A table that was left in the middle of a step is not saved; the old file stays.
      log_error(
          fmt::format("{}: memory: expected room for the scene, the picture and the table of at most {:.4g} MB "
                      "(--table-memory), found none left; nothing is saved, what had been is as it was",
                      settings_.scene.string(), double(settings_.table.memory_bytes) / double(1 << 20)));
    }
    telemetry_.summary("failed", {}, cache());
    return 1;
  }

 private:
  int rendered() {
    const InterruptGuard& interrupt = interrupt_;
    fibers_.add_fibers(scene_);
    if (const int status = saved_ != nullptr ? resume() : open_cache(); status != 0) return status;
    const Deadline deadline(interrupt.requested(), checkpoint_ != nullptr ? settings_.checkpoint_deadline : 0,
                            [this] { return live_.is_look_asked(); });
    build_strands();

    integrate::RenderOptions options = settings_.render;
    const SampleRange samples = samples_of(settings_, scene_);
    integrate::set_asked(scene_.integrator, rows_learn(), &options);
    options.first_sample = samples.from;
    options.samples = samples.to - samples.from;
    if (saved_ != nullptr) options.resume = &saved_->render;
    // If the samples are rendered in parts, each pixel has its own share, so that no two parts have the same.
    options.adaptive = scene_.integrator.adaptive.value_or(settings_.stop.noise || settings_.stop.seconds) &&
                       !settings_.samples_from && !settings_.samples_to;
    options.mattes = counts_objects();
    options.audit = fibers_.audit();
    if (!fibers_.model().evaluates() && !fibers_.model().estimates()) {
      options.light_samples = 0;
      log_note(fmt::format("model {} can only be sampled: light is met by chance, and small lights make noise",
                           settings_.model));
    }
    if (fiber::has(*fiber::find_model(settings_.model), fiber::Asks::samples)) {
      integrate::measure_needs(options.near, scene_, *strands_);
      end_.near = integrate::words_of(options.near);
      log_note(end_.near);
    } else {
      options.near.where = integrate::NearOptions::Where::nowhere;
    }
    live_.begin(scene_, fiber::estimator_name(estimator_of(settings_)), service_);
    Forecast forecast(settings_.stop);
    std::optional<integrate::FilteredNoise> filtered;
    if (settings_.denoise && settings_.stop.noise) filtered.emplace(*settings_.stop.noise, scene_);
    Progress progress;
    integrate::RenderResult result = integrate::render(
        scene_, *strands_, fibers_.model(), fibers_.fiber_ids(), service_, options, deadline.passed(),
        [&](const integrate::PassProgress& pass) {
          const double elapsed = std::chrono::duration<double>(Clock::now() - start_).count();
          const Outlook ahead = forecast.after(pass, filtered ? filtered->after(pass) : pass.noise, elapsed);
          telemetry_.pass(pass);
          progress.update(pass, ahead);
          if (cache_) {
            cache_->add_cost(pass.table);
            cache_->save_if_due(*service_);
          }
          if (ahead.reason != nullptr) end_.stopped_by = ahead.reason;
          end_.noise = pass.noise;
          end_.bias_bound = pass.table.bias_bound;
          end_.picture_error = settings_.stop.picture_error;
          if (const integrate::Brightening* bias = integrate::StopRule::bias_of(pass); bias && end_.picture_error)
            end_.is_within_error = integrate::StopRule::is_within(*bias, *end_.picture_error);
          if (ahead.reason == nullptr && !deadline.passed()) checkpoint(pass, interrupt.requested());
          if (settings_.part && !deadline.passed()) write_part(pass, options);
          const auto save_layers = [&] { write_partial(pass, Partial::layers); };
          const bool goes_on = live_.after_pass(pass, ahead, interrupt.requested(), save_layers);
          if (!goes_on && ahead.reason == nullptr) end_.stopped_by = "page";
          return goes_on && ahead.reason == nullptr && !interrupt.requested();
        });
    progress.finish();
    if (live_.is_look_asked() && !interrupt.requested()) {
      live_.leave_look(std::move(result.picture), result.passes);
      return dropped();
    }
    if (result.unusable) {
      log_error(fmt::format("{}: expected the sums of this picture, found others", checkpoint_->file().string()));
      return 1;
    }
    end_.seconds = progress.seconds() + seconds_before_;
    return save(result, interrupt.exit_status());
  }

  void build_strands() {
    if (strands_) return;
    Step building(fmt::format("building the tree over {} strands", strand_count()));
    strands_ = std::make_unique<const geometry::FiberScene>(scene_, [&](double share) { building.set_share(share); });
  }

  int dropped() {
    dropped_ = true;
    if (carried_ != nullptr && service_ != nullptr) *carried_ = fibers_.hand_over();
    return 0;
  }

  /// Continues from the checkpoint.
  int resume() {
    if (service_ != nullptr) {
      if (std::optional<Error> refused = service_->restore(saved_->table.value_or(""))) {
        refused->file = checkpoint_->file().string();
        log_error(refused->message());
        return 1;
      }
    }
    if (cache_) {
      cache_->resume(saved_->progress);
      freeze_if_asked();
    }
    const auto seconds = saved_->progress.find("seconds");
    if (seconds != saved_->progress.end() && seconds->is_number())
      seconds_before_ = std::clamp(seconds->get<double>(), 0.0, 1e9);
    start_ -= std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds_before_));
    telemetry_.resume(saved_->render.passes);
    telemetry_.listen(service_);
    log_note(fmt::format("{}: goes on after {} passes", checkpoint_->file().string(), saved_->render.passes));
    return 0;
  }

  bool rows_learn() const { return service_ != nullptr && settings_.cache_mode != CacheMode::frozen; }

  /// Freezes the table if requested, so that it answers every picture alike, whichever part of it is rendered.
  void freeze_if_asked() {
    if (settings_.cache_mode == CacheMode::frozen && cache_->loaded() == "loaded") service_->set_learning(false);
  }

  const WarmCacheSession* cache() const { return cache_ ? &*cache_ : nullptr; }

  nlohmann::json progress_so_far() const {
    nlohmann::json state = cache_ ? cache_->progress() : nlohmann::json::object();
    state["seconds"] = std::chrono::duration<double>(Clock::now() - start_).count();
    state["telemetry_bytes"] = telemetry_.bytes();
    return state;
  }

  void checkpoint(const integrate::PassProgress& pass, bool now) {
    if (checkpoint_ == nullptr || !(now || checkpoint_->is_due())) return;
    const Clock::time_point start = Clock::now();
    const std::clock_t cpu = std::clock();
    const bool saved = checkpoint_->save(pass, service_, progress_so_far());
    if (!now) write_partial(pass, Partial::beauty);
    checkpoint_->spent(Clock::now() - start);
    if (saved)
      log_note(fmt::format("checkpoint {}: {} passes, saved in {:.3f} s of CPU", checkpoint_->file().string(),
                           pass.pass + 1, static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC));
  }

  /// The contents of a partial picture. beauty: quick to write, for every checkpoint.
  enum class Partial { beauty, layers };

  /// A failure is logged once, until a write succeeds.
  void write_partial(const integrate::PassProgress& pass, Partial what) {
    image::Picture partial = what == Partial::beauty ? pass.film->beauty_picture() : pass.film->picture();
    partial.whole_width = scene_.image.width;
    partial.whole_height = scene_.image.height;
    partial.metadata["settings"] = identity_text(identity_);
    partial.metadata["stopped_by"] = "checkpoint";
    keep_asked_layers(settings_, &partial);
    const auto compression = what == Partial::beauty ? image::Compression::none : image::Compression::zip;
    const auto error = image::write_exr(settings_.output, partial, settings_.precision, compression);
    if (error && !partial_fails_) log_warning("no picture so far: " + error->message());
    partial_fails_ = error.has_value();
  }

  /// Writes the part after the last pass, while the film exists.
  void write_part(const integrate::PassProgress& pass, const integrate::RenderOptions& options) {
    if (pass.pass + 1 < pass.pass_count) return;
    PartHeader part = part_header_of(settings_, scene_, identity_, counts_objects());
    part.window = pass.film->window();
    part.table = service_ != nullptr ? adaptive::cache_hash(*service_->rows()) : "";
    part.frozen = !rows_learn() && options.roulette == integrate::Roulette::throughput;
    part_failed_ = write_saved_render(*settings_.part, identity_, to_json(part), pass, nullptr);
    if (!part_failed_) log_note(fmt::format("{}: part for tress merge", settings_.part->string()));
  }

  bool is_wanted(const char* layer) const {
    return !settings_.layers || std::ranges::find(*settings_.layers, layer) != settings_.layers->end();
  }

  bool counts_objects() const { return is_wanted("CryptoObject") || is_wanted("CryptoMaterial"); }

  std::size_t strand_count() const {
    std::size_t count = 0;
    for (const scene::Groom& groom : scene_.grooms) count += groom.strand_count() * groom.times();
    return count;
  }

  int open_cache() {
    std::optional<Error> refused;
    if (cache_) {
      if (carried_ != nullptr && carried_->service) refused = cache_->take(*service_, *carried_->service->rows());
      if (carried_ == nullptr || !carried_->service || refused) refused = cache_->open(*service_);
      freeze_if_asked();
    } else if (service_ != nullptr && carried_ != nullptr && carried_->service) {
      refused = service_->load(*carried_->service->rows());
    } else if (settings_.warm_cache) {
      log_warning(fmt::format("warm cache {}: not used and left as it is, {}", settings_.warm_cache->string(),
                              fiber::find_model(settings_.model)->has_rows()
                                  ? "the exact estimator has no rows"
                                  : fmt::format("model {} has no rows", settings_.model)));
    }
    telemetry_.header(scene_, threads_, service_, cache());
    telemetry_.listen(service_);
    if (!refused) return 0;
    log_error(fmt::format("warm cache {} is required: {}", cache_->file().string(), refused->message()));
    telemetry_.summary("refused", {}, cache());
    return 1;
  }

  int save(integrate::RenderResult& result, int signal_status) {
    if (service_ != nullptr) end_.cache_hash = adaptive::cache_hash(*service_->rows());
    describe_request(settings_, scene_, identity_, &result.picture);
    describe_result(result, end_, &result.picture.metadata);
    PictureFiles files;
    if (settings_.denoise) end_.denoised_noise = denoise_picture(settings_.output, &result.picture);
    const std::optional<std::filesystem::path> written = write_pictures(settings_, scene_, result, &files);
    files.check(part_failed_);
    // This comes last: it may have to wait for another session, and the picture must not.
    if (cache_) files.check(cache_->save(*service_));
    if (carried_ != nullptr && service_ != nullptr) *carried_ = fibers_.hand_over();
    telemetry_.summary(files.failed() ? "failed" : (signal_status != 0 ? "interrupted" : "done"),
                       summary_fields(result, end_, written.value_or(settings_.output)), cache());
    // A render that is killed before this goes on from its checkpoint; after it, all its files are written.
    if (checkpoint_ != nullptr && !files.failed() && signal_status == 0) checkpoint_->remove();
    live_.finish(std::move(result.picture));
    if (result.dropped_samples > 0) {
      log_warning(
          fmt::format("{} samples were infinite or not a number and are left out of the picture, which is the mean of "
                      "the others; materials that return more light than falls on them (`gain` above 1) make such",
                      result.dropped_samples));
    }
    if (cache_) cache_->log_savings();
    if (written) {
      log_note(fmt::format("{}{}: {:.4g} samples a pixel in {:.1f} s", signal_status != 0 ? "interrupted, " : "",
                           written->string(), result.samples_per_pixel, end_.seconds));
    }
    return files.failed() || telemetry_.failed() ? 1 : signal_status;
  }

  const RenderSettings& settings_;
  const scene::Scene& scene_;
  int threads_;
  Clock::time_point start_;
  RenderTelemetry telemetry_;
  SceneModel fibers_;
  adaptive::Service* service_;  ///< from fibers_; null without rows
  std::optional<WarmCacheSession> cache_;
  const Identity& identity_;
  CheckpointSession* checkpoint_;  ///< null if not requested
  const SavedRender* saved_;       ///< null to render from the start
  fiber::ModelService* carried_;   ///< null if no frame comes before or after this one
  LiveView& live_;
  const InterruptGuard& interrupt_;
  std::unique_ptr<const geometry::FiberScene>& strands_;
  bool dropped_ = false;
  double seconds_before_ = 0;  ///< time of the runs before this one
  std::optional<Error> part_failed_;
  bool partial_fails_ = false;  ///< whether the last partial picture could not be written
  RenderEnd end_;
};

/// Applies the look to the scene and the settings. False if the scene cannot have it, because a variation of its
/// strands leaves a range; only the scene's look is then lost.
bool took_look(const scene::Unstyled& unstyled, const RenderSettings& settings, scene::Scene* scene,
               RenderFiles* files) {
  if (const std::optional<Error> error = scene::restyle(unstyled, settings.overrides, scene)) {
    files->live.refuse_look(error->message());
    return false;
  }
  for (const auto& [option, text] : settings.given_options) files->identity[option] = text;
  for (const char* option : {"--color", "--melanin", "--sigma-a", "--hair"})
    if (!settings.given_options.contains(option)) files->identity.erase(option);
  return true;
}

/// Renders one picture after another as the live page changes the look, until one is done. Strands and tree stay in
/// memory, the tree as long as no cross-section changes; rows that are still valid are kept.
int rendered_by_looks(const RenderSettings& settings, const scene::Unstyled& unstyled, scene::Scene& scene, int threads,
                      Clock::time_point start, RenderFiles& files) {
  fiber::ModelService learned;
  files.live.offer(sliders_of(settings, scene), color_of(scene));
  for (RenderSettings now = settings;;) {
    {
      RenderJob job(now, scene, threads, start, files, &learned);
      const int status = job.run();
      if (!job.is_dropped()) return status;
    }
    start = Clock::now();
    RenderSettings next = with_look(settings, files.live.take_look());
    if (!took_look(unstyled, next, &scene, &files)) {
      next = now;
      if (!took_look(unstyled, next, &scene, &files)) return 1;
    }
    if (next.overrides.eccentricity != now.overrides.eccentricity) files.strands.reset();
    now = std::move(next);
  }
}

}  // namespace

int render_one(const RenderSettings& asked, TelemetryLines* shared, fiber::ModelService* carried) {
  const Clock::time_point start = Clock::now();
  std::optional<Step> reading(std::in_place, "reading " + asked.scene.string());
  scene::Unstyled unstyled;
  Result<scene::Scene> scene = scene::load_scene(asked.scene, asked.overrides, asked.serve ? &unstyled : nullptr);
  reading.reset();
  if (!scene) {
    log_error(scene.error().message());
    return 1;
  }
  for (const std::string& text : scene->notes) log_note(text);
  for (const std::string& text : scene->warnings) log_warning(text);
  RenderSettings settings = asked;
  if (asked.model_of_scene) settings.model = model_of_scene(*scene);
  if (const std::string message = refused_option(asked.asked, settings.model, !asked.model_of_scene);
      !message.empty()) {
    log_error(message);
    return 2;
  }
  log_model_lacks(*scene, settings.model);
  if (const int status = log_refusal(settings, *scene); status != 0) return status;
  const Identity identity = identity_of(settings.scene, settings.given_options, settings.overrides.settings);
  std::optional<CheckpointSession> checkpoint;
  std::optional<SavedRender> saved;
  if (settings.checkpoint) {
    checkpoint.emplace(checkpoint_file(settings), settings.checkpoint_interval, identity);
    Result<std::optional<SavedRender>> there = checkpoint->open();
    if (!there) {
      log_error(there.error().message() + "; to begin anew, remove it");
      return 1;
    }
    saved = std::move(*there);
  }
  Result<TelemetryLines> own = TelemetryLines::open(std::nullopt);
  if (shared == nullptr || (saved && shared->wanted())) {
    std::uint64_t bytes = 0;
    if (saved && saved->progress.contains("telemetry_bytes") && saved->progress["telemetry_bytes"].is_number_unsigned())
      bytes = saved->progress["telemetry_bytes"].get<std::uint64_t>();
    own = saved ? TelemetryLines::resume(settings.telemetry, bytes) : TelemetryLines::open(settings.telemetry);
  }
  if (!own) {
    log_error(own.error().message());
    return 1;
  }
  if (shared != nullptr && own->wanted()) *shared = std::move(*own);
  const Result<std::unique_ptr<LiveView>> live = LiveView::open(settings);
  if (!live) {
    log_error(live.error().message());
    return 1;
  }
  return run_threaded(settings.threads, [&](int threads) {
    const InterruptGuard interrupt;
    RenderFiles files{
        identity, std::move(checkpoint), std::move(saved), shared != nullptr ? *shared : *own, **live, interrupt,
        nullptr};
    if (settings.serve) return rendered_by_looks(settings, unstyled, *scene, threads, start, files);
    RenderJob job(settings, *scene, threads, start, files, carried);
    return job.run();
  });
}

}  // namespace tress::cli
