// What a render has found: told, put into the header of its picture, and written.
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

/// How it ended, beside what integrate::RenderResult has.
struct RenderEnd {
  const char* stopped_by = "signal";     ///< or "samples", "noise", "time", "page"
  double noise = 0, bias_bound = 0;      ///< after the last pass
  double seconds = 0;                    ///< wall time, of the runs before too
  std::string cache_hash;                ///< of the table; empty without one
  std::optional<double> denoised_noise;  ///< what the filter leaves of it; unset: not filtered
};

/// Into the header; what the fits of the table make of the brightness is logged too.
void describe_result(const integrate::RenderResult& result, const RenderEnd& end,
                     std::map<std::string, std::string>* header);

/// The noise that is left. Logged, if it cannot be filtered: the picture is then as it was rendered. output: its file.
std::optional<double> denoise_picture(const std::filesystem::path& output, image::Picture* picture);

/// The picture, its preview and its heat map. Where the picture is; unset: nowhere.
std::optional<std::filesystem::path> write_pictures(const RenderSettings& settings, const scene::Scene& scene,
                                                    const integrate::RenderResult& result, PictureFiles* files);

/// Of the telemetry's last line. written: where the picture is.
RenderTelemetry::Extra summary_fields(const integrate::RenderResult& result, const RenderEnd& end,
                                      const std::filesystem::path& written);

}  // namespace tress::cli
