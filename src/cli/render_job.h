// Renders one picture, from the settings to the saved files, and learns on the way.
#pragma once

#include "cli/render_settings.h"
#include "cli/telemetry_lines.h"

namespace tress::fiber {
struct ModelService;
}

namespace tress::cli {

/// Returns the exit status: 0, 1 if a file could not be read or written, 2 for options that do not fit the scene, 128 +
/// the signal that ended it. shared: telemetry in one file with the frames before this one; null: a file of its own.
/// carried: what the frame before has learned, replaced by what this one has; null: no frame comes before or after.
int render_one(const RenderSettings& settings, TelemetryLines* shared, fiber::ModelService* carried);

}  // namespace tress::cli
