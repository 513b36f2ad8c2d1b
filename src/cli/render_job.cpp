#include "cli/render_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <memory>
#include <new>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "cli/console.h"
#include "cli/options.h"
#include "cli/output_files.h"
#include "cli/process.h"
#include "cli/progress.h"
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

/// One render, from the loaded scene to the saved files.
class RenderJob {
 public:
  RenderJob(const RenderSettings& settings, const scene::Scene& scene, int threads, Clock::time_point start,
            TelemetryLines telemetry)
      : settings_(settings),
        info_(*references::find_model(settings.model)),
        scene_(scene),
        threads_(threads),
        start_(start),
        telemetry_(std::move(telemetry)) {
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
    if (const int status = open_cache(); status != 0) return status;
    std::optional<Step> building(std::in_place, fmt::format("building the tree over {} strands", strand_count()));
    const geometry::FiberScene fibers(scene_, [&](double share) { building->tell(share); });
    building.reset();

    integrate::RenderOptions options = settings_.render;
    options.samples = settings_.stop.samples(scene_.image.samples);
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
        integrate::render(scene_, fibers, *model_, fiber_ids_, service_, options, interrupt.requested(),
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
                            return ahead.reason == nullptr && !interrupt.requested();
                          });
    progress.finish();
    return save(result, progress.seconds(), interrupt.exit_status());
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
      refused = cache_->open(*service_);
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
    telemetry_.write([&](adaptive::TelemetryWriter& writer) { return writer.header(fields); });
    if (!settings_.telemetry_rows || !service_ || !telemetry_.wanted()) return;
    service_->set_row_listener([this](const adaptive::RowReport& row) {
      telemetry_.write([&](adaptive::TelemetryWriter& writer) { return writer.row(row, row_fields(row)); });
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
    telemetry_.write([&](adaptive::TelemetryWriter& writer) { return writer.pass(pass.table, fields); });
    passes_told_ = pass.pass + 1;
  }

  void told_summary(const char* status, Extra fields) {
    fields.emplace("status", json_text(status));
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
    // Last: it may have to wait for another session, and the picture must not.
    if (cache_) told(cache_->save(*service_));

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
  TelemetryLines telemetry_;
  int passes_told_ = 0;
  const char* stopped_by_ = "signal";
  double noise_ = 0, bias_bound_ = 0;  ///< after the last pass
  double learning_cpu_seconds_ = 0;    ///< of all passes, as the next
  std::uint64_t g_evaluations_ = 0;
};

/// What must be writable, checked before anything is rendered.
std::optional<Error> check_outputs(const RenderSettings& settings) {
  std::filesystem::path preview = settings.output;
  preview.replace_extension(".png");
  if (auto error = check_output(settings.output)) return error;
  if (auto error = check_output(preview)) return error;
  if (settings.heatmap) {
    if (auto error = check_output(*settings.heatmap)) return error;
  }
  if (settings.warm_cache && settings.cache_mode != CacheMode::frozen) {
    return check_output(*settings.warm_cache);
  }
  return std::nullopt;
}

}  // namespace

int run_render(const RenderSettings& settings) {
  const Clock::time_point start = Clock::now();
  std::optional<Step> reading(std::in_place, "reading " + settings.scene.string());
  const Result<scene::Scene> scene = scene::load_scene(settings.scene, settings.overrides);
  reading.reset();
  if (!scene) {
    log_error(scene.error().message());
    return 1;
  }
  if (const auto& crop = settings.render.crop) {
    const auto [x0, y0, x1, y1] = edges_of(*crop);
    if (x1 > scene->image.width || y1 > scene->image.height) {
      log_error(fmt::format("--crop: expected pixels within {} x {}, found {},{},{},{}", scene->image.width,
                            scene->image.height, x0, y0, x1, y1));
      return 2;
    }
  }
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
  Result<TelemetryLines> telemetry = TelemetryLines::open(settings.telemetry);
  if (!telemetry) {
    log_error(telemetry.error().message());
    return 1;
  }

  return run_threaded(settings.threads, [&](int threads) {
    RenderJob job(settings, *scene, threads, start, std::move(*telemetry));
    return job.run();
  });
}

}  // namespace tress::cli
