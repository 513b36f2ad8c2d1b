// What `tress render` writes as telemetry: a header, a line a pass and a changed row, a summary (keys:
// adaptive/telemetry/README.md).
#pragma once

#include <optional>

#include "cli/render_settings.h"
#include "cli/telemetry_lines.h"
#include "integrate/renderer.h"
#include "tress/adaptive/service.h"
#include "tress/adaptive/telemetry.h"

namespace tress::cli {

/// One thread, between passes.
class RenderTelemetry {
 public:
  using Extra = adaptive::TelemetryWriter::Extra;

  /// settings and lines outlive it.
  RenderTelemetry(const RenderSettings& settings, TelemetryLines& lines) : settings_(settings), lines_(lines) {}

  /// service: null: the model asks no rows. cache: null: the render has none.
  void header(const scene::Scene& scene, int threads, const adaptive::Service* service, const WarmCacheSession* cache);
  /// A line for each row that changes from now on, where the settings ask for them; every slice of the service is
  /// there. The service tells this object until its listener is replaced.
  void listen(adaptive::Service* service);
  /// With how far the rows are from the picture's own paths, whenever their number has passed a power of 2.
  void pass(const integrate::PassProgress& pass);
  void summary(const char* status, Extra fields, const WarmCacheSession* cache);
  /// In place of header(), where a checkpoint had so many passes told.
  void resume(int passes) { passes_told_ = passes; }

  std::uint64_t bytes() const { return lines_.bytes(); }
  bool failed() const { return lines_.failed(); }

 private:
  void add_frame(Extra& fields) const;

  const RenderSettings& settings_;
  TelemetryLines& lines_;
  adaptive::Service* service_ = nullptr;  ///< that was listened to
  int passes_told_ = 0;
};

/// {"paths": ..., "chi2": ..., "deviation": ..., "common_chi2": ..., "common_deviation": ...}.
std::string heard_text(const adaptive::HeardTest& test);
/// {"value": ..., "error": ...}: of brightness, relative.
std::string brightening_text(const integrate::Brightening& excess);
/// {"value": ..., "error": ..., "paths": ...}.
std::string deep_light_text(const integrate::DeepLightBias& bias);

}  // namespace tress::cli
