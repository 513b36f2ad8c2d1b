// The telemetry of `tress render`: a header, a line for each pass and each changed row, a summary (keys:
// adaptive/telemetry/README.md).
#pragma once

#include <optional>

#include "cli/render_settings.h"
#include "cli/telemetry_lines.h"
#include "integrate/renderer.h"
#include "tress/adaptive/service.h"
#include "tress/adaptive/telemetry.h"

namespace tress::cli {

/// Use it from one thread, between passes.
class RenderTelemetry {
 public:
  using Extra = adaptive::TelemetryWriter::Extra;

  /// settings and lines must outlive it.
  RenderTelemetry(const RenderSettings& settings, TelemetryLines& lines) : settings_(settings), lines_(lines) {}

  /// service: null if the model has no rows. cache: null if the render has none.
  void header(const scene::Scene& scene, int threads, const adaptive::Service* service, const WarmCacheSession* cache);
  /// Writes a line for each row that changes from now on, if the settings request it; all slices must have been added
  /// to the service. The service calls this object until its listener is replaced.
  void listen(adaptive::Service* service);
  /// Writes a line for a pass. Whenever the number of the picture's own paths passes a power of 2, the line has the
  /// test of the rows by these paths.
  void pass(const integrate::PassProgress& pass);
  void summary(const char* status, Extra fields, const WarmCacheSession* cache);
  /// Replaces header() in a render that continues from a checkpoint with this many passes.
  void resume(int passes) { passes_written_ = passes; }

  std::uint64_t bytes() const { return lines_.bytes(); }
  bool failed() const { return lines_.failed(); }

 private:
  void add_frame(Extra& fields) const;

  const RenderSettings& settings_;
  TelemetryLines& lines_;
  adaptive::Service* service_ = nullptr;  ///< the service with this listener
  int passes_written_ = 0;
};

/// {"paths": ..., "chi2": ..., "deviation": ..., "common_chi2": ..., "common_deviation": ...}.
std::string heard_text(const adaptive::HeardTest& test);
/// {"value": ..., "error": ...}, relative to the brightness.
std::string brightening_text(const integrate::Brightening& excess);
/// {"value": ..., "error": ..., "paths": ...}.
std::string deep_light_text(const integrate::DeepLightBias& bias);

}  // namespace tress::cli
