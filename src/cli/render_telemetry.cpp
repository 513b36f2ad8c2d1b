#include "cli/render_telemetry.h"

#include <bit>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "cli/render_checks.h"
#include "cli/row_words.h"

namespace tress::cli {
namespace {

using Extra = RenderTelemetry::Extra;

Extra cache_fields(const RenderSettings& settings, const WarmCacheSession* cache) {
  if (!settings.warm_cache) return {};
  nlohmann::ordered_json warm_cache = {{"file", (cache != nullptr ? cache->file() : *settings.warm_cache).string()},
                                       {"mode", cache_mode_name(settings.cache_mode)}};
  if (cache != nullptr)
    warm_cache.update(cache->telemetry());
  else
    warm_cache["loaded"] = "not asked";
  return {{"warm_cache", json_text(warm_cache)}};
}

}  // namespace

void RenderTelemetry::header(const scene::Scene& scene, int threads, const adaptive::Service* service,
                             const WarmCacheSession* cache) {
  const fiber::ModelInfo& info = *fiber::find_model(settings_.model);
  Extra fields{{"scene", json_text(scene.source)},
               {"model", json_text(info.name)},
               {"estimator", json_text(fiber::estimator_name(estimator_of(settings_)))},
               {"learner", json_text(info.learner_name(settings_.table))},
               {"epsilon", json_text(info.epsilon(settings_.table))},
               {"seed", json_text(settings_.render.seed)},
               {"samples", json_text(settings_.stop.samples(scene.image.samples))},
               {"width", json_text(scene.image.width)},
               {"height", json_text(scene.image.height)},
               {"threads", json_text(threads)},
               {"pages", json_text(service ? service->slice_count() : 0)},
               {"memory_limit", json_text(settings_.table.memory_bytes)}};
  if (settings_.quadrature_points) fields.emplace("quadrature_points", json_text(*settings_.quadrature_points));
  if (settings_.stop.seconds) fields.emplace("time_limit", json_text(*settings_.stop.seconds));
  if (settings_.stop.noise) fields.emplace("noise_target", json_text(*settings_.stop.noise));
  if (const auto& crop = settings_.render.crop) fields.emplace("crop", json_text(edges_of(*crop)));
  if (settings_.table.picture_error > 0) fields.emplace("picture_error", json_text(settings_.table.picture_error));
  fields.merge(cache_fields(settings_, cache));
  add_frame(fields);
  lines_.write([&](adaptive::TelemetryWriter& writer) { return writer.header(fields); });
}

// If one file has many frames, each line names its frame.
void RenderTelemetry::add_frame(Extra& fields) const {
  if (!settings_.frames.empty()) fields.emplace("frame", json_text(*settings_.overrides.frame));
}

void RenderTelemetry::listen(adaptive::Service* service) {
  service_ = service;
  if (!settings_.telemetry_rows || service == nullptr || !lines_.wanted()) return;
  std::map<adaptive::SliceKey, adaptive::SliceId> slices;
  for (adaptive::SliceId id = 0; id < service->slice_count(); ++id) slices.emplace(service->slice(id).key, id);
  service->set_row_listener([this, service, slices = std::move(slices)](const adaptive::RowReport& row) {
    Extra fields{{"pass", json_text(passes_written_)}};
    if (const auto slice = slices.find(row.slice); slice != slices.end())
      fields.merge(words_of_row(service->slice(slice->second), row.node, settings_.table.epsilon));
    add_frame(fields);
    lines_.write([&](adaptive::TelemetryWriter& writer) { return writer.row(row, fields); });
  });
}

void RenderTelemetry::pass(const integrate::PassProgress& pass) {
  Extra fields{{"pass", json_text(pass.pass)},
               {"pixels", json_text(pass.pixels)},
               {"samples", json_text(pass.paths_so_far)},
               {"dropped_samples", json_text(pass.dropped_samples)},
               {"seconds", json_text(pass.seconds)},
               {"cpu_seconds", json_text(pass.cpu_seconds)},
               {"deeper_places", json_text(pass.deeper.places)},
               {"deeper_copies", json_text(pass.deeper.copies)},
               {"deeper_bytes", json_text(pass.deeper.bytes)},
               {"deeper_cpu_seconds", json_text(pass.deeper.cpu_seconds)},
               {"noise", json_text(pass.noise)}};
  if (pass.excess) fields.emplace("bias_estimate", brightening_text(*pass.excess));
  const std::uint64_t heard = pass.table.heard_paths, heard_before = heard - pass.table.newly_heard;
  if (service_ != nullptr && lines_.wanted() && std::bit_width(heard) != std::bit_width(heard_before))
    fields.emplace("heard_test", heard_text(service_->test_by_heard()));
  if (pass.deep_light) fields.emplace("deep_light_bias", deep_light_text(*pass.deep_light));
  add_frame(fields);
  lines_.write([&](adaptive::TelemetryWriter& writer) { return writer.pass(pass.table, fields); });
  passes_written_ = pass.pass + 1;
}

void RenderTelemetry::summary(const char* status, Extra fields, const WarmCacheSession* cache) {
  fields.emplace("status", json_text(status));
  if (service_ != nullptr && lines_.wanted()) {
    if (const adaptive::HeardTest test = service_->test_by_heard(); test.paths > 0)
      fields.emplace("heard_test", heard_text(test));
  }
  add_frame(fields);
  fields.merge(cache_fields(settings_, cache));
  lines_.write([&](adaptive::TelemetryWriter& writer) { return writer.summary(fields); });
}

std::string deep_light_text(const integrate::DeepLightBias& bias) {
  return json_text(nlohmann::ordered_json{{"value", bias.value}, {"error", bias.error}, {"paths", bias.paths}});
}

std::string heard_text(const adaptive::HeardTest& test) {
  return json_text(nlohmann::ordered_json{{"paths", test.paths},
                                          {"chi2", test.chi2},
                                          {"deviation", test.deviation},
                                          {"common_chi2", test.common_chi2},
                                          {"common_deviation", test.common_deviation}});
}

std::string brightening_text(const integrate::Brightening& excess) {
  return json_text(nlohmann::ordered_json{{"value", excess.value}, {"error", excess.error}});
}

}  // namespace tress::cli
