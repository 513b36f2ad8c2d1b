#include "cli/render_job.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <memory>
#include <new>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stop_token>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "cli/checkpoint_session.h"
#include "cli/console.h"
#include "cli/frame_list.h"
#include "cli/options.h"
#include "cli/output_files.h"
#include "cli/process.h"
#include "cli/progress.h"
#include "cli/render_identity.h"
#include "cli/row_words.h"
#include "cli/telemetry_lines.h"
#include "geometry/fiber_scene.h"
#include "integrate/camera_projection.h"
#include "references/registry.h"
#include "scene/model/light.h"
#include "tress/adaptive/telemetry.h"
#include "tress/version.h"

namespace tress::cli {
namespace {

using Extra = adaptive::TelemetryWriter::Extra;
using Clock = std::chrono::steady_clock;

/// X0, Y0, X1, Y1 as on the command line.
std::array<int, 4> edges_of(const image::Window& window) {
  return {window.left, window.top, window.left + window.width, window.top + window.height};
}

/// As JSON with the keys of a scene file.
std::string camera_text(const scene::Camera& camera) {
  const auto triple = [](const glm::vec3& x) { return nlohmann::ordered_json{x.x, x.y, x.z}; };
  nlohmann::ordered_json keys{
      {"eye", triple(camera.eye)}, {"look_at", triple(camera.look_at)}, {"up", triple(camera.up)}};
  if (camera.orthographic_height_cm > 0)
    keys["orthographic_height_cm"] = camera.orthographic_height_cm;
  else
    keys["vertical_fov_deg"] = camera.vertical_fov_deg;
  if (camera.shift_x != 0) keys["shift_x"] = camera.shift_x;
  if (camera.shift_y != 0) keys["shift_y"] = camera.shift_y;
  if (camera.lens_radius_cm > 0) {
    nlohmann::ordered_json& lens = keys["depth_of_field"];
    lens = {{"radius_cm", camera.lens_radius_cm}, {"focus_cm", camera.focus_cm}};
    if (camera.blades > 0) lens["blades"] = camera.blades;
    if (camera.blades > 0) lens["blade_rotation_deg"] = camera.blade_rotation_rad * 180 / std::numbers::pi_v<float>;
  }
  return json_text(keys);
}

/// Of --layers: a group of light that the scene does not have.
std::optional<Error> unknown_group(const RenderSettings& settings, const scene::Scene& scene) {
  const std::vector<std::string> groups = scene::light_groups(scene);
  for (const std::string& layer : settings.layers.value_or(std::vector<std::string>{})) {
    if (!layer.starts_with(light_layer) || std::ranges::count(groups, layer.substr(light_layer.size())) > 0) continue;
    return Error{"", "--layers",
                 groups.empty() ? "layers of a scene whose lights have no `group`"
                                : "light. with one of the groups " + joined(groups, ", "),
                 layer};
  }
  return std::nullopt;
}

/// Brightness against that of the same model without a table.
std::string brightening_words(const integrate::Brightening& excess) {
  return fmt::format(
      "the fits of the table make the picture {:.2g} % {} than tracing every vertex would, give or take {:.2g} %",
      100 * std::abs(excess.value), excess.value < 0 ? "darker" : "brighter", 100 * excess.error);
}

std::string brightening_text(const integrate::Brightening& excess) {
  return json_text(nlohmann::ordered_json{{"value", excess.value}, {"error", excess.error}});
}

/// What is open before a render begins.
struct RenderFiles {
  Identity identity;
  std::optional<CheckpointSession> checkpoint;
  std::optional<SavedRender> saved;  ///< what the checkpoint had
  TelemetryLines& telemetry;
};

/// After a signal the running pass may go on for a while, so that nothing of it is lost.
class Deadline {
 public:
  /// seconds: 0: none.
  Deadline(const std::atomic<bool>& asked, double seconds)
      : asked_(asked), watcher_([this, seconds](const std::stop_token& over) { watch(over, seconds); }) {}
  const std::atomic<bool>& passed() const { return passed_; }

 private:
  void watch(const std::stop_token& over, double seconds) {
    constexpr std::chrono::milliseconds step{20};
    double left = seconds;
    while (!over.stop_requested() && !(asked_ && left <= 0)) {
      std::this_thread::sleep_for(step);
      if (asked_) left -= std::chrono::duration<double>(step).count();
    }
    if (asked_ && left <= 0) passed_ = true;
  }

  const std::atomic<bool>& asked_;
  std::atomic<bool> passed_{false};
  std::jthread watcher_;
};

/// One render, from the loaded scene to the saved files.
class RenderJob {
 public:
  RenderJob(const RenderSettings& settings, const scene::Scene& scene, int threads, Clock::time_point start,
            RenderFiles& files, fiber::ModelService* carried)
      : settings_(settings),
        info_(*references::find_model(settings.model)),
        scene_(scene),
        threads_(threads),
        start_(start),
        identity_(files.identity),
        checkpoint_(files.checkpoint ? &*files.checkpoint : nullptr),
        saved_(files.saved ? &*files.saved : nullptr),
        carried_(carried),
        telemetry_(files.telemetry) {
    if (info_.has_rows() && settings.estimator != fiber::Estimator::exact) {
      adaptive::Options options = settings.table;
      options.seed = settings.render.seed;
      // A frozen table is used as it is: it learns nothing, the light of its rows neither.
      if (settings.cache_mode == CacheMode::frozen) {
        options.sampled_epsilon = std::max(options.sampled_epsilon, options.faint_sampled_epsilon);
        if (options.picture_error > 0) options.epsilon = options.sampled_epsilon = 1;
      }
      learned_ = fiber::make_service(info_, options);
      service_ = learned_.service.get();
    }
    if (settings.warm_cache && service_) {
      cache_.emplace(*settings.warm_cache, settings.cache_mode, learned_.target->model_name());
    }
    model_ = info_.make({settings.estimator, service_, settings.quadrature_points.value_or(0)});
    if (settings.audited_share) unbiased_ = info_.make({fiber::Estimator::exact, nullptr});
  }

  /// Inside the arena.
  int run() {
    try {
      return rendered();
    } catch (const std::bad_alloc&) {
      // A table that was left in the middle of a step is not saved; what had been is as it was.
      log_error(
          fmt::format("{}: memory: expected room for the scene, the picture and the table of at most {:.4g} MB "
                      "(--table-memory), found none left; nothing is saved, what had been is as it was",
                      settings_.scene.string(), double(settings_.table.memory_bytes) / double(1 << 20)));
    }
    told_summary("failed", {});
    return 1;
  }

 private:
  int rendered() {
    const InterruptGuard interrupt;
    add_fibers();
    if (const int status = saved_ != nullptr ? resume() : open_cache(); status != 0) return status;
    const Deadline deadline(interrupt.requested(), checkpoint_ != nullptr ? settings_.checkpoint_deadline : 0);
    std::optional<Step> building(std::in_place, fmt::format("building the tree over {} strands", strand_count()));
    const geometry::FiberScene fibers(scene_, [&](double share) { building->tell(share); });
    building.reset();

    integrate::RenderOptions options = settings_.render;
    options.first_sample = settings_.samples_from.value_or(0);
    options.samples =
        settings_.samples_to.value_or(settings_.stop.samples(scene_.image.samples)) - options.first_sample;
    if (saved_ != nullptr) options.resume = &saved_->render;
    // Of samples that are taken apart each pixel has its own share, so that no two parts have the same.
    options.adaptive = settings_.adaptive.value_or(settings_.stop.noise || settings_.stop.seconds) &&
                       !settings_.samples_from && !settings_.samples_to;
    options.mattes = is_wanted("CryptoObject") || is_wanted("CryptoMaterial");
    if (!model_->evaluates()) {
      options.light_samples = 0;
      log_note(fmt::format("model {} can only be sampled: light is met by chance, and small lights make noise",
                           model_->name()));
    }
    const integrate::BiasAudit audit = bias_audit();
    if (unbiased_) options.audit = &audit;
    Forecast forecast(settings_.stop);
    Progress progress;
    integrate::RenderResult result =
        integrate::render(scene_, fibers, *model_, fiber_ids_, service_, options, deadline.passed(),
                          [&](const integrate::PassProgress& pass) {
                            const double elapsed = std::chrono::duration<double>(Clock::now() - start_).count();
                            const Outlook ahead = forecast.after(pass, elapsed);
                            told_pass(pass);
                            progress.update(pass, ahead);
                            if (cache_) cache_->save_if_due(*service_);
                            if (ahead.reason != nullptr) stopped_by_ = ahead.reason;
                            noise_ = pass.noise;
                            bias_bound_ = pass.table.bias_bound;
                            learning_cpu_seconds_ += pass.table.learning_cpu_seconds;
                            g_evaluations_ += pass.table.g_evaluations;
                            if (ahead.reason == nullptr && !deadline.passed()) checkpoint(pass, interrupt.requested());
                            if (settings_.part && !deadline.passed()) tell_part(pass);
                            return ahead.reason == nullptr && !interrupt.requested();
                          });
    progress.finish();
    if (result.unusable) {
      log_error(fmt::format("{}: expected the sums of this picture, found others", checkpoint_->file().string()));
      return 1;
    }
    return save(result, progress.seconds() + seconds_before_, interrupt.exit_status());
  }

  /// Goes on where a checkpoint was written.
  int resume() {
    const nlohmann::json& told = saved_->progress;
    const auto text = [&](const char* name) {
      return told.contains(name) && told[name].is_string() ? told[name].get<std::string>() : std::string();
    };
    const auto number = [&](const char* name) {
      return told.contains(name) && told[name].is_number() ? told[name].get<double>() : 0.0;
    };
    const auto whole = [&](const char* name) {
      return static_cast<std::uint64_t>(std::clamp(number(name), 0.0, 1e15));
    };
    std::optional<Error> refused;
    if (service_ != nullptr) refused = service_->restore(saved_->table.value_or(""));
    if (refused) {
      refused->file = checkpoint_->file().string();
      log_error(refused->message());
      return 1;
    }
    if (cache_) {
      cache_->resume(text("cache_loaded"), whole("cache_rows"), whole("cache_rows_known"),
                     whole("cache_samples_known"));
      if (settings_.cache_mode == CacheMode::frozen && cache_->loaded() == "loaded") service_->set_learning(false);
    }
    seconds_before_ = std::clamp(number("seconds"), 0.0, 1e9);
    start_ -= std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds_before_));
    passes_told_ = saved_->render.passes;
    learning_cpu_seconds_ = std::clamp(number("learning_cpu_seconds"), 0.0, 1e9);
    g_evaluations_ = whole("g_evaluations");
    listen();
    log_note(fmt::format("{}: goes on after {} passes", checkpoint_->file().string(), saved_->render.passes));
    return 0;
  }

  nlohmann::json progress_so_far() const {
    nlohmann::json told{{"seconds", std::chrono::duration<double>(Clock::now() - start_).count()},
                        {"telemetry_bytes", telemetry_.bytes()},
                        {"learning_cpu_seconds", learning_cpu_seconds_},
                        {"g_evaluations", g_evaluations_}};
    if (cache_) {
      told["cache_loaded"] = cache_->loaded();
      told["cache_rows"] = cache_->rows_loaded();
      told["cache_rows_known"] = cache_->rows_known();
      told["cache_samples_known"] = cache_->samples_known();
    }
    return told;
  }

  void checkpoint(const integrate::PassProgress& pass, bool now) {
    if (checkpoint_ == nullptr || !(now || checkpoint_->is_due())) return;
    const Clock::time_point start = Clock::now();
    if (checkpoint_->save(pass, service_, progress_so_far()) && !now) {
      image::Picture partial = pass.film->picture();
      partial.whole_width = scene_.image.width;
      partial.whole_height = scene_.image.height;
      partial.metadata["settings"] = identity_text(identity_);
      partial.metadata["stopped_by"] = "checkpoint";
      if (settings_.layers) image::keep_layers(*settings_.layers, &partial);
      if (const auto error = image::write_exr(settings_.output, partial, settings_.precision))
        log_warning("checkpoint: no picture so far: " + error->message());
    }
    checkpoint_->spent(Clock::now() - start);
  }

  /// After the last pass, where the film is there.
  void tell_part(const integrate::PassProgress& pass) {
    if (pass.pass + 1 < pass.pass_count) return;
    const image::Window& window = pass.film->window();
    const nlohmann::json told{
        {"window", {window.left, window.top, window.width, window.height}},
        {"whole", {scene_.image.width, scene_.image.height}},
        {"samples",
         {settings_.samples_from.value_or(0),
          settings_.samples_to.value_or(settings_.stop.samples(scene_.image.samples))}},
        {"opaque", scene_.environment_visible && !scene_.image.transparent},
        {"glint",
         std::ranges::any_of(scene_.fibers, [](const fiber::FiberParameters& fiber) { return fiber.split_glint; })},
        {"moving", scene_.next.has_value()},
        {"groups", nlohmann::json(scene::light_groups(scene_))},
        {"emission", std::ranges::any_of(scene_.lights, [](const scene::Light& light) { return light.visible; })},
        {"table", service_ != nullptr ? adaptive::cache_hash(*service_->rows()) : ""},
        {"frozen", service_ == nullptr || settings_.cache_mode == CacheMode::frozen}};
    part_failed_ = write_saved_render(*settings_.part, identity_, told, pass, nullptr);
    if (!part_failed_) log_note(fmt::format("{}: part for tress merge", settings_.part->string()));
  }

  bool is_wanted(const char* layer) const {
    return !settings_.layers || std::ranges::find(*settings_.layers, layer) != settings_.layers->end();
  }

  integrate::BiasAudit bias_audit() {
    integrate::BiasAudit audit;
    if (!unbiased_) return audit;
    audit.unbiased = unbiased_.get();
    audit.share = *settings_.audited_share;
    for (const fiber::FiberParameters& parameters : scene_.fibers)
      audit.fiber_ids.push_back(unbiased_->add_fiber(parameters));
    return audit;
  }

  std::size_t strand_count() const {
    std::size_t count = 0;
    for (const scene::Groom& groom : scene_.grooms) count += groom.fiber.size();
    return count;
  }

  void add_fibers() {
    {
      Step step(
          fmt::format("energies of {} kind{} of fiber", scene_.fibers.size(), scene_.fibers.size() == 1 ? "" : "s"));
      for (const fiber::FiberParameters& parameters : scene_.fibers) {
        fiber_ids_.push_back(model_->add_fiber(parameters));
        step.tell(static_cast<double>(fiber_ids_.size()) / static_cast<double>(scene_.fibers.size()));
      }
    }
    for (const scene::Material& material : scene_.materials) tell_narrow_blurs(material);
    if (!service_) return;
    log_note(fmt::format("{} pages for {} fiber{}, table of at most {:.4g} MB", service_->slice_count(),
                         scene_.fibers.size(), scene_.fibers.size() == 1 ? "" : "s",
                         double(settings_.table.memory_bytes) / double(1 << 20)));
  }

  /// Under a blur of 4 degrees a grid of rows would explode, and g is traced at every vertex instead.
  void tell_narrow_blurs(const scene::Material& material) const {
    if (!service_ || info_.learns_samples()) return;
    const std::array<float, 3> sigmas = fiber::azimuthal_sigmas(material.fiber);
    for (int lobe = 0; lobe < 3; ++lobe) {
      const double degrees = double(sigmas[std::size_t(lobe)]) * 180 / std::numbers::pi;
      if (degrees >= 4) continue;
      log_note(
          fmt::format("material {}: {} is blurred by {:.2f} degrees, less than 4: its rows only propose, and it is "
                      "traced at every vertex",
                      material.name, fiber::lobe_names[std::size_t(lobe) + 1], degrees));
    }
  }

  int open_cache() {
    std::optional<Error> refused;
    if (cache_) {
      if (carried_ != nullptr && carried_->service) refused = cache_->take(*service_, *carried_->service->rows());
      if (carried_ == nullptr || !carried_->service || refused) refused = cache_->open(*service_);
      // A frozen table answers every picture alike, whatever part of it is rendered.
      if (settings_.cache_mode == CacheMode::frozen && cache_->loaded() == "loaded") service_->set_learning(false);
    } else if (settings_.warm_cache) {
      log_warning(
          fmt::format("warm cache {}: not used, the exact estimator has no rows", settings_.warm_cache->string()));
    }
    told_header();
    if (!refused) return 0;
    log_error(fmt::format("warm cache {} is required: {}", settings_.warm_cache->string(), refused->message()));
    told_summary("refused", {});
    return 1;
  }

  /// A model without rows is what it is at every vertex.
  const char* estimator_name() const {
    return fiber::estimator_name(info_.has_rows() ? settings_.estimator : fiber::Estimator::exact);
  }

  /// What learning the rows that were there would have cost at the pace of those that were learned here; unset where
  /// too few were to tell.
  std::optional<double> seconds_spared() const {
    constexpr std::uint64_t enough = 10000;
    if (g_evaluations_ < enough) return std::nullopt;
    return learning_cpu_seconds_ / static_cast<double>(g_evaluations_) * static_cast<double>(cache_->samples_known());
  }

  /// What the warm cache was good for.
  void tell_savings() const {
    if (!cache_ || cache_->rows_known() == 0) return;
    const std::optional<double> seconds = seconds_spared();
    log_note(fmt::format("warm cache {}: {} rows had been learned before, from {} samples{}", cache_->file().string(),
                         cache_->rows_known(), cache_->samples_known(),
                         seconds ? fmt::format("; estimated by the rows learned now, that is {:.2g} s of CPU", *seconds)
                                 : std::string()));
  }

  Extra cache_fields() const {
    if (!settings_.warm_cache) return {};
    nlohmann::ordered_json cache = {{"file", settings_.warm_cache->string()},
                                    {"mode", cache_mode_name(settings_.cache_mode)}};
    if (cache_) {
      cache["loaded"] = cache_->loaded();
      cache["rows_loaded"] = cache_->rows_loaded();
      if (cache_->rows_known() > 0) {
        cache["rows_known"] = cache_->rows_known();
        cache["samples_known"] = cache_->samples_known();
        if (const std::optional<double> seconds = seconds_spared()) cache["cpu_seconds_spared_estimate"] = *seconds;
      }
      cache["saved"] = cache_->saved();
      cache["rows_saved"] = cache_->rows_saved();
      if (!cache_->reason().empty()) cache["reason"] = cache_->reason();
    } else {
      cache["loaded"] = "not asked";
    }
    return {{"warm_cache", json_text(cache)}};
  }

  void told_header() {
    Extra fields{{"scene", json_text(scene_.source)},
                 {"model", json_text(model_->name())},
                 {"estimator", json_text(estimator_name())},
                 {"learner", json_text(info_.learner_name(settings_.table))},
                 {"epsilon", json_text(info_.epsilon(settings_.table))},
                 {"seed", json_text(settings_.render.seed)},
                 {"samples", json_text(settings_.stop.samples(scene_.image.samples))},
                 {"width", json_text(scene_.image.width)},
                 {"height", json_text(scene_.image.height)},
                 {"threads", json_text(threads_)},
                 {"pages", json_text(service_ ? service_->slice_count() : 0)},
                 {"memory_limit", json_text(settings_.table.memory_bytes)}};
    if (settings_.quadrature_points) fields.emplace("quadrature_points", json_text(*settings_.quadrature_points));
    if (settings_.stop.seconds) fields.emplace("time_limit", json_text(*settings_.stop.seconds));
    if (settings_.stop.noise) fields.emplace("noise_target", json_text(*settings_.stop.noise));
    if (const auto& crop = settings_.render.crop) fields.emplace("crop", json_text(edges_of(*crop)));
    if (settings_.table.picture_error > 0) fields.emplace("picture_error", json_text(settings_.table.picture_error));
    fields.merge(cache_fields());
    add_frame(fields);
    telemetry_.write([&](adaptive::TelemetryWriter& writer) { return writer.header(fields); });
    listen();
  }

  /// Where one file tells of many frames, each line says of which.
  void add_frame(Extra& fields) const {
    if (!settings_.frames.empty()) fields.emplace("frame", json_text(*settings_.overrides.frame));
  }

  void listen() {
    if (!settings_.telemetry_rows || !service_ || !telemetry_.wanted()) return;
    service_->set_row_listener([this](const adaptive::RowReport& row) {
      Extra fields = row_fields(row);
      add_frame(fields);
      telemetry_.write([&](adaptive::TelemetryWriter& writer) { return writer.row(row, fields); });
    });
  }

  Extra row_fields(const adaptive::RowReport& row) const {
    Extra fields{{"pass", json_text(passes_told_)}};
    for (adaptive::SliceId id = 0; id < service_->slice_count(); ++id) {
      const adaptive::SliceDescription& slice = service_->slice(id);
      if (slice.key == row.slice) fields.merge(words_of_row(slice, row.node, settings_.table.epsilon));
    }
    return fields;
  }

  void told_pass(const integrate::PassProgress& pass) {
    Extra fields{{"pass", json_text(pass.pass)},
                 {"pixels", json_text(pass.pixels)},
                 {"samples", json_text(pass.paths_so_far)},
                 {"dropped_samples", json_text(pass.dropped_samples)},
                 {"seconds", json_text(pass.seconds)},
                 {"cpu_seconds", json_text(pass.cpu_seconds)},
                 {"noise", json_text(pass.noise)}};
    if (pass.excess) fields.emplace("bias_estimate", brightening_text(*pass.excess));
    add_frame(fields);
    telemetry_.write([&](adaptive::TelemetryWriter& writer) { return writer.pass(pass.table, fields); });
    passes_told_ = pass.pass + 1;
  }

  void told_summary(const char* status, Extra fields) {
    fields.emplace("status", json_text(status));
    add_frame(fields);
    fields.merge(cache_fields());
    telemetry_.write([&](adaptive::TelemetryWriter& writer) { return writer.summary(fields); });
  }

  int save(integrate::RenderResult& result, double seconds, int signal_status) {
    bool failed = false;
    const auto told = [&](const std::optional<Error>& error) {
      if (!error) return false;
      log_error(error->message());
      return failed = true;
    };
    /// Where it is written: to `file`, or, told, elsewhere; nowhere: nothing.
    const auto write = [&](const std::filesystem::path& file, const auto& to) -> std::optional<std::filesystem::path> {
      if (!told(to(file))) {
        remove_leftovers(file);
        return file;
      }
      for (const std::filesystem::path& place : other_places(file)) {
        if (to(place)) continue;
        log_warning(fmt::format("{}: saved as {} instead", file.string(), place.string()));
        return place;
      }
      return std::nullopt;
    };

    std::string hash;
    if (service_) hash = adaptive::cache_hash(*service_->rows());
    image::Picture& picture = result.picture;
    picture.metadata["scene"] = scene_.source;
    picture.metadata["settings"] = identity_text(identity_);
    picture.metadata["command"] = settings_.command;
    picture.metadata["version"] = version();
    if (settings_.overrides.frame) picture.metadata["frame"] = std::to_string(*settings_.overrides.frame);
    picture.metadata["camera"] = camera_text(scene_.camera);
    integrate::describe_camera(scene_.camera, scene_.image, &picture);
    picture.metadata["noise"] = fmt::format("{:.4g}", noise_);
    picture.metadata["exposure"] = fmt::format("{} stops, of the PNG alone", scene_.image.exposure_stops);
    picture.metadata["view"] = image::view_names()[static_cast<std::size_t>(scene_.image.view)] +
                               ", of the PNG alone; these pixels are linear";
    picture.metadata["seed"] = std::to_string(settings_.render.seed);
    picture.metadata["samples"] = fmt::format("{}", result.samples_per_pixel);
    picture.metadata["dropped_samples"] = std::to_string(result.dropped_samples);
    picture.metadata["stopped_by"] = stopped_by_;
    if (result.excess) {
      picture.metadata["bias_estimate"] = fmt::format("{:.4f} +- {:.4f}", result.excess->value, result.excess->error);
      log_note(brightening_words(*result.excess));
    }
    if (result.bias) {
      picture.metadata["bias"] = fmt::format("{:.4f} +- {:.4f}", result.bias->value, result.bias->error);
      log_note(fmt::format("bias of the brightness {:.2g} %, standard error {:.2g} %, by {} paths without rows",
                           100 * result.bias->value, 100 * result.bias->error, result.bias->paths));
    }
    picture.metadata["time"] = fmt::format("{:.3f} s", seconds);
    picture.metadata["model"] = model_->name();
    if (settings_.quadrature_points)
      picture.metadata["quadrature_points"] = std::to_string(*settings_.quadrature_points);
    picture.metadata["estimator"] = estimator_name();
    picture.metadata["epsilon"] = fmt::format("{}", info_.epsilon(settings_.table));
    picture.metadata["cache_hash"] = hash;
    picture.metadata["alpha"] = scene_.environment_visible && !scene_.image.transparent
                                    ? "opaque: R, G, B have the background, A is 1"
                                    : "premultiplied: R, G, B have no background, A is the coverage";
    image::Picture kept = picture;
    if (settings_.layers) image::keep_layers(*settings_.layers, &kept);
    const auto written = write(settings_.output, [&](const std::filesystem::path& file) {
      return image::write_exr(file, kept, settings_.precision);
    });
    std::filesystem::path preview = written.value_or(settings_.output);
    preview.replace_extension(".png");
    const image::Preview look{scene_.image.transparent, scene_.image.exposure_stops, scene_.image.view};
    write(preview, [&](const std::filesystem::path& file) { return image::write_png(file, picture, look); });
    if (result.heatmap) {
      write(*settings_.heatmap,
            [&](const std::filesystem::path& file) { return image::write_exr(file, *result.heatmap); });
    }
    told(part_failed_);
    // Last: it may have to wait for another session, and the picture must not.
    if (cache_) told(cache_->save(*service_));
    if (checkpoint_ != nullptr && !failed && signal_status == 0) checkpoint_->remove();
    if (carried_ != nullptr && service_ != nullptr) hand_over();

    Extra fields{{"passes", json_text(result.passes)},
                 {"samples_per_pixel", json_text(result.samples_per_pixel)},
                 {"dropped_samples", json_text(result.dropped_samples)},
                 {"seconds", json_text(seconds)},
                 {"stopped_by", json_text(stopped_by_)},
                 {"noise", json_text(noise_)},
                 {"bias_bound", json_text(bias_bound_)},
                 {"queries", json_text(result.queries)},
                 {"exact_queries", json_text(result.exact_queries)},
                 {"cache_hash", json_text(hash)},
                 {"image", json_text(written.value_or(settings_.output).string())}};
    if (result.excess) fields.emplace("bias_estimate", brightening_text(*result.excess));
    if (result.bias) {
      const nlohmann::json bias{
          {"value", result.bias->value}, {"error", result.bias->error}, {"paths", result.bias->paths}};
      fields.emplace("bias_measured", json_text(bias));
    }
    told_summary(failed ? "failed" : (signal_status != 0 ? "interrupted" : "done"), std::move(fields));
    if (result.dropped_samples > 0) {
      log_warning(
          fmt::format("{} samples were infinite or not a number and are left out of the picture, which is the mean of "
                      "the others; materials that return more light than falls on them (`gain` above 1) make such",
                      result.dropped_samples));
    }
    tell_savings();
    if (written) {
      log_note(fmt::format("{}{}: {:.4g} samples a pixel in {:.1f} s", signal_status != 0 ? "interrupted, " : "",
                           written->string(), result.samples_per_pixel, seconds));
    }
    return failed || telemetry_.failed() ? 1 : signal_status;
  }

  /// What was learned, to the next frame. The model that asks it goes with this job, after this.
  void hand_over() {
    model_.reset();
    service_->set_row_listener({});
    *carried_ = std::move(learned_);
    service_ = nullptr;
  }

  const RenderSettings& settings_;
  const fiber::ModelInfo& info_;
  const scene::Scene& scene_;
  int threads_;
  Clock::time_point start_;
  fiber::ModelService learned_;
  adaptive::Service* service_ = nullptr;  ///< of learned_; null: no rows are asked
  std::unique_ptr<fiber::FiberModel> model_;
  std::unique_ptr<fiber::FiberModel> unbiased_;  ///< the same model without rows, where the bias is measured
  std::optional<WarmCacheSession> cache_;
  std::vector<fiber::FiberId> fiber_ids_;
  const Identity& identity_;
  CheckpointSession* checkpoint_;  ///< null: not asked for
  const SavedRender* saved_;       ///< null: from the start
  fiber::ModelService* carried_;   ///< null: no frame comes before or after this one
  double seconds_before_ = 0;      ///< of the runs before this one
  std::optional<Error> part_failed_;
  TelemetryLines& telemetry_;
  int passes_told_ = 0;
  const char* stopped_by_ = "signal";
  double noise_ = 0, bias_bound_ = 0;  ///< after the last pass
  double learning_cpu_seconds_ = 0;    ///< of all passes, as the next
  std::uint64_t g_evaluations_ = 0;
};

std::filesystem::path checkpoint_file(const RenderSettings& settings) {
  std::filesystem::path file = *settings.checkpoint;
  return file.empty() ? std::filesystem::path(settings.output).replace_extension(".checkpoint") : file;
}

/// What must be writable, checked before anything is rendered.
std::optional<Error> check_outputs(const RenderSettings& settings) {
  std::filesystem::path preview = settings.output;
  preview.replace_extension(".png");
  if (auto error = check_output(settings.output)) return error;
  if (auto error = check_output(preview)) return error;
  if (settings.heatmap) {
    if (auto error = check_output(*settings.heatmap)) return error;
  }
  if (settings.checkpoint) {
    if (auto error = check_output(checkpoint_file(settings))) return error;
  }
  if (settings.part) {
    if (auto error = check_output(*settings.part)) return error;
  }
  if (settings.warm_cache && settings.cache_mode != CacheMode::frozen) {
    return check_output(*settings.warm_cache);
  }
  return std::nullopt;
}

/// What the command line cannot know before the scene does.
int told_wrong_ranges(const RenderSettings& settings, const scene::Scene& scene) {
  if (const auto& crop = settings.render.crop) {
    const auto [x0, y0, x1, y1] = edges_of(*crop);
    if (x1 > scene.image.width || y1 > scene.image.height) {
      log_error(fmt::format("--crop: expected pixels within {} x {}, found {},{},{},{}", scene.image.width,
                            scene.image.height, x0, y0, x1, y1));
      return 2;
    }
  }
  const int from = settings.samples_from.value_or(0);
  const int to = settings.samples_to.value_or(settings.stop.samples(scene.image.samples));
  if (from >= to) {
    log_error(fmt::format("--samples-from: expected a sample before {}, where they end, found {}", to, from));
    return 2;
  }
  return 0;
}

/// One picture. telemetry: of the frames before this one too, in one file; null: a file of its own.
int render_one(const RenderSettings& settings, TelemetryLines* shared, fiber::ModelService* carried) {
  const Clock::time_point start = Clock::now();
  std::optional<Step> reading(std::in_place, "reading " + settings.scene.string());
  const Result<scene::Scene> scene = scene::load_scene(settings.scene, settings.overrides);
  reading.reset();
  if (!scene) {
    log_error(scene.error().message());
    return 1;
  }
  if (const int status = told_wrong_ranges(settings, *scene); status != 0) return status;
  if (const std::optional<Error> error = unknown_group(settings, *scene)) {
    log_error(error->message());
    return 2;
  }
  for (const std::string& text : scene->notes) log_note(text);
  for (const std::string& text : scene->warnings) log_warning(text);
  if (const std::optional<Error> error = check_outputs(settings)) {
    log_error(error->message());
    return 1;
  }
  const Identity identity = identity_of(settings.scene, settings.told);
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
  return run_threaded(settings.threads, [&](int threads) {
    RenderFiles files{identity, std::move(checkpoint), std::move(saved), shared != nullptr ? *shared : *own};
    RenderJob job(settings, *scene, threads, start, files, carried);
    return job.run();
  });
}

/// The settings of one frame: its files, its seed, its camera.
RenderSettings settings_of(const RenderSettings& all, int frame) {
  RenderSettings one = all;
  one.overrides.frame = frame;
  one.told["frame"] = std::to_string(frame);
  if (all.seed_of_frame) one.render.seed = static_cast<std::uint64_t>(frame);
  one.output = of_frame(all.output, frame);
  for (std::optional<std::filesystem::path>* file : {&one.telemetry, &one.heatmap, &one.checkpoint, &one.part}) {
    if (*file) *file = of_frame(**file, frame);
  }
  return one;
}

/// Whether the picture is there, whole, and of these settings.
bool is_finished(const RenderSettings& settings) {
  std::error_code error;
  if (!std::filesystem::exists(settings.output, error)) return false;
  const Result<image::Picture> picture = image::read_exr(settings.output);
  if (!picture) return false;
  const auto of = [&](const char* name) {
    const auto found = picture->metadata.find(name);
    return found == picture->metadata.end() ? std::string() : found->second;
  };
  if (of("stopped_by") == "signal" || of("stopped_by") == "checkpoint") return false;
  return of("settings") == identity_text(identity_of(settings.scene, settings.told));
}

struct FrameCount {
  int rendered = 0, skipped = 0;
  std::vector<std::string> failed;
};

void tell_frames(const FrameCount& count, std::size_t frames, int signal_status) {
  log_note(fmt::format("{}{} frames: {} rendered, {} finished before, {} failed{}{}",
                       signal_status != 0 ? "interrupted, " : "", frames, count.rendered, count.skipped,
                       count.failed.size(), count.failed.empty() ? "" : ": ", fmt::join(count.failed, ",")));
}

int render_frames(const RenderSettings& settings) {
  FrameCount count;
  fiber::ModelService learned;
  // A file for all frames goes on: the frames that are skipped are in it.
  const bool shares = settings.telemetry && !names_frames(*settings.telemetry);
  std::error_code error;
  const std::uintmax_t size = shares ? std::filesystem::file_size(*settings.telemetry, error) : 0;
  Result<TelemetryLines> lines = TelemetryLines::open(std::nullopt);
  if (shares) {
    lines = error || settings.overwrite ? TelemetryLines::open(settings.telemetry)
                                        : TelemetryLines::resume(settings.telemetry, size);
    if (!lines) {
      log_error(lines.error().message());
      return 1;
    }
  }
  for (const int frame : settings.frames) {
    const RenderSettings one = settings_of(settings, frame);
    if (!settings.overwrite && is_finished(one)) {
      log_note(fmt::format("frame {}: finished, {}", frame, one.output.string()));
      ++count.skipped;
      continue;
    }
    const int status = render_one(one, shares ? &*lines : nullptr, settings.warm_cache ? &learned : nullptr);
    if (status == 2) return status;
    if (status > 128) {
      tell_frames(count, settings.frames.size(), status);
      return status;
    }
    if (status == 0) ++count.rendered;
    if (status != 0) count.failed.push_back(std::to_string(frame));
  }
  tell_frames(count, settings.frames.size(), 0);
  return count.failed.empty() ? 0 : 1;
}

}  // namespace

int run_render(const RenderSettings& settings) {
  return settings.frames.empty() ? render_one(settings, nullptr, nullptr) : render_frames(settings);
}

}  // namespace tress::cli
