// Logs the result of a render, writes it into the header of its picture, and writes the files.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "cli/picture_files.h"
#include "cli/render_settings.h"
#include "cli/render_telemetry.h"
#include "integrate/renderer.h"

namespace tress::cli {

/// The end of a render, in addition to integrate::RenderResult.
struct RenderEnd {
  const char* stopped_by = "signal";     ///< or "samples", "noise", "time", "page"
  double noise = 0, bias_bound = 0;      ///< after the last pass
  std::optional<double> picture_error;   ///< the limit that was asked for
  std::optional<bool> is_within_error;   ///< whether the bias is known to be within it; unset: no limit or no estimate
  double seconds = 0;                    ///< wall time, including earlier runs
  std::string cache_hash;                ///< hash of the table; empty without a table
  std::string near = {};                 ///< integrate::words_of(); empty if the model has no near hits
  std::optional<double> denoised_noise;  ///< noise after filtering; unset: not filtered
};

/// Writes the result into the header, and logs how the fits of the table change the brightness.
void describe_result(const integrate::RenderResult& result, const RenderEnd& end,
                     std::map<std::string, std::string>* header);

/// Filters the picture and returns the noise that is left. If that fails it is logged, and the picture stays as it was
/// rendered. output: its file.
std::optional<double> denoise_picture(const std::filesystem::path& output, image::Picture* picture);

/// Writes the picture, its preview and its heat map. Returns the place of the picture; empty if it could not be
/// written.
std::optional<std::filesystem::path> write_pictures(const RenderSettings& settings, const scene::Scene& scene,
                                                    const integrate::RenderResult& result, PictureFiles* files);

/// The fields of the telemetry's last line. written: the place of the picture.
RenderTelemetry::Extra summary_fields(const integrate::RenderResult& result, const RenderEnd& end,
                                      const std::filesystem::path& written);

}  // namespace tress::cli
