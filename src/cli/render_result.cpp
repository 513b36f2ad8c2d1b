#include "cli/render_result.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "cli/console.h"
#include "cli/telemetry_lines.h"
#include "denoise/denoised_layer.h"
#include "image/deep_picture.h"

namespace tress::cli {
namespace {

/// The brightness relative to the same model without a table, in words.
std::string brightening_words(const integrate::Brightening& excess) {
  return fmt::format(
      "the fits of the table make the picture {:.2g} % {} than tracing every vertex would, give or take {:.2g} %",
      100 * std::abs(excess.value), excess.value < 0 ? "darker" : "brighter", 100 * excess.error);
}

/// What is known of the bias and its limit, in words.
std::string words_of(double limit, const std::optional<bool>& is_within) {
  if (!is_within) return fmt::format("learned as {:.4g} asks; the bias is not estimated (--measure-bias does)", limit);
  return fmt::format("the bias is {}within {:.4g} by two standard errors", *is_within ? "" : "not known to be ", limit);
}

}  // namespace

void describe_result(const integrate::RenderResult& result, const RenderEnd& end,
                     std::map<std::string, std::string>* header) {
  std::map<std::string, std::string>& entries = *header;
  entries["noise"] = fmt::format("{:.4g}", end.noise);
  entries["samples"] = fmt::format("{}", result.samples_per_pixel);
  entries["dropped_samples"] = std::to_string(result.dropped_samples);
  entries["stopped_by"] = end.stopped_by;
  if (!end.near.empty()) entries["near"] = end.near;
  entries["time"] = fmt::format("{:.3f} s", end.seconds);
  entries["cache_hash"] = end.cache_hash;
  if (end.picture_error) {
    entries["picture_error"] = words_of(*end.picture_error, end.is_within_error);
    log_note("picture error: " + entries["picture_error"]);
  }
  if (result.excess) {
    entries["bias_estimate"] = fmt::format("{:.4f} +- {:.4f}", result.excess->value, result.excess->error);
    log_note(brightening_words(*result.excess));
  }
  if (result.deep_light) {
    const integrate::DeepLightBias& bias = *result.deep_light;
    entries["deep_light_bias"] = fmt::format("{:.4f} +- {:.4f}", bias.value, bias.error);
    log_note(
        fmt::format("light from deep in the hair is learned: it makes the hair {:.2g} % {} than traced light would, "
                    "give or take {:.2g} %, by {} paths that were traced on",
                    100 * std::abs(bias.value), bias.value < 0 ? "darker" : "brighter", 100 * bias.error, bias.paths));
  }
  if (!result.bias) return;
  entries["bias"] = fmt::format("{:.4f} +- {:.4f}", result.bias->value, result.bias->error);
  log_note(fmt::format("bias of the brightness {:.2g} %, standard error {:.2g} %, by {} paths without rows",
                       100 * result.bias->value, 100 * result.bias->error, result.bias->paths));
}

std::optional<double> denoise_picture(const std::filesystem::path& output, image::Picture* picture) {
  const Result<denoise::Denoised> found = denoise::add_denoised(output.string(), picture);
  if (found) {
    log_note("denoised: " + denoise::denoised_words(*found));
    return found->noise();
  }
  log_warning("not denoised: " + found.error().message());
  picture->metadata["denoised"] = "no: " + found.error().message();
  return std::nullopt;
}

std::optional<std::filesystem::path> write_pictures(const RenderSettings& settings, const scene::Scene& scene,
                                                    const integrate::RenderResult& result, PictureFiles* files) {
  image::Picture kept = result.picture;
  keep_asked_layers(settings, &kept);
  const auto written = files->write(settings.output, [&](const std::filesystem::path& file) {
    return image::write_exr(file, kept, settings.precision);
  });
  std::filesystem::path preview = written.value_or(settings.output);
  preview.replace_extension(".png");
  const image::Preview look{scene.image.transparent, scene.image.exposure_stops, scene.image.view,
                            denoise::denoised_layer};
  files->write(preview,
               [&](const std::filesystem::path& file) { return image::write_png(file, result.picture, look); });
  if (result.heatmap) {
    files->write(*settings.heatmap,
                 [&](const std::filesystem::path& file) { return image::write_exr(file, *result.heatmap); });
  }
  if (result.deep) {
    kept.channels.clear();
    image::keep_layers({}, &kept);  // without mattes, which the header would name
    // OpenEXR has a number of that name in deep files.
    if (auto version = kept.metadata.extract("version")) {
      version.key() = "tress_version";
      kept.metadata.insert(std::move(version));
    }
    files->write(*settings.deep,
                 [&](const std::filesystem::path& file) { return image::write_deep_exr(file, *result.deep, kept); });
  }
  return written;
}

RenderTelemetry::Extra summary_fields(const integrate::RenderResult& result, const RenderEnd& end,
                                      const std::filesystem::path& written) {
  RenderTelemetry::Extra fields{{"passes", json_text(result.passes)},
                                {"samples_per_pixel", json_text(result.samples_per_pixel)},
                                {"dropped_samples", json_text(result.dropped_samples)},
                                {"seconds", json_text(end.seconds)},
                                {"stopped_by", json_text(end.stopped_by)},
                                {"noise", json_text(end.noise)},
                                {"bias_bound", json_text(end.bias_bound)},
                                {"queries", json_text(result.queries)},
                                {"exact_queries", json_text(result.exact_queries)},
                                {"cache_hash", json_text(end.cache_hash)},
                                {"image", json_text(written.string())}};
  if (result.excess) fields.emplace("bias_estimate", brightening_text(*result.excess));
  if (result.deep_light) fields.emplace("deep_light_bias", deep_light_text(*result.deep_light));
  if (result.bias) {
    const nlohmann::json bias{
        {"value", result.bias->value}, {"error", result.bias->error}, {"paths", result.bias->paths}};
    fields.emplace("bias_measured", json_text(bias));
  }
  if (end.is_within_error) fields.emplace("picture_error_reached", json_text(*end.is_within_error));
  if (end.denoised_noise) fields.emplace("denoised_noise", json_text(*end.denoised_noise));
  return fields;
}

}  // namespace tress::cli
