#include "cli/render_frames.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "cli/console.h"
#include "cli/frame_list.h"
#include "cli/render_identity.h"
#include "cli/render_job.h"
#include "cli/telemetry_lines.h"
#include "image/picture.h"

namespace tress::cli {
namespace {

/// The settings of one frame: its files, its seed, its camera.
RenderSettings settings_of(const RenderSettings& all, int frame) {
  RenderSettings one = all;
  one.overrides.frame = frame;
  one.given_options["frame"] = std::to_string(frame);
  if (all.seed_of_frame) one.render.seed = static_cast<std::uint64_t>(frame);
  one.output = of_frame(all.output, frame);
  for (std::optional<std::filesystem::path>* file :
       {&one.telemetry, &one.heatmap, &one.deep, &one.checkpoint, &one.part}) {
    if (*file) *file = of_frame(**file, frame);
  }
  return one;
}

/// Whether the picture exists, is whole, and has these settings.
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
  return of("settings") ==
         identity_text(identity_of(settings.scene, settings.given_options, settings.overrides.settings));
}

struct FrameCount {
  int rendered = 0, skipped = 0;
  std::vector<std::string> failed;
};

void log_frames(const FrameCount& count, std::size_t frames, int signal_status) {
  log_note(fmt::format("{}{} frames: {} rendered, {} finished before, {} failed{}{}",
                       signal_status != 0 ? "interrupted, " : "", frames, count.rendered, count.skipped,
                       count.failed.size(), count.failed.empty() ? "" : ": ", fmt::join(count.failed, ",")));
}

int render_frames(const RenderSettings& settings) {
  FrameCount count;
  fiber::ModelService learned;
  // One file for all frames is continued: it contains the frames that are skipped.
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
    begin_picture(std::size_t(count.rendered + count.skipped) + count.failed.size(), settings.frames.size());
    if (!settings.overwrite && is_finished(one)) {
      log_note(fmt::format("frame {}: finished, {}", frame, one.output.string()));
      ++count.skipped;
      continue;
    }
    const int status = render_one(one, shares ? &*lines : nullptr, settings.warm_cache ? &learned : nullptr);
    if (status == 2) return status;
    if (status > 128) {
      log_frames(count, settings.frames.size(), status);
      return status;
    }
    if (status == 0) ++count.rendered;
    if (status != 0) count.failed.push_back(std::to_string(frame));
  }
  log_frames(count, settings.frames.size(), 0);
  return count.failed.empty() ? 0 : 1;
}

}  // namespace

int run_render(const RenderSettings& settings) {
  return settings.frames.empty() ? render_one(settings, nullptr, nullptr) : render_frames(settings);
}

}  // namespace tress::cli
