// One picture, from the settings to the saved files, learning on the way.
#pragma once

#include "cli/render_settings.h"
#include "cli/telemetry_lines.h"

namespace tress::fiber {
struct ModelService;
}

namespace tress::cli {

/// Exit status: 0, 1 if a file could not be read or written, 2 for options that do not fit the scene, 128 + the signal
/// that ended it. shared: the telemetry of the frames before this one too, in one file; null: a file of its own.
/// carried: what the frame before has learned, replaced by what this one has; null: no frame comes before or after.
int render_one(const RenderSettings& settings, TelemetryLines* shared, fiber::ModelService* carried);

}  // namespace tress::cli
