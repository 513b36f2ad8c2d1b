// Renders one picture, from the settings to the saved files, and learns on the way.
#pragma once

#include "cli/render_settings.h"
#include "cli/telemetry_lines.h"

namespace tress::inline v0_2::fiber {
struct ModelService;
}

namespace tress::cli {

/// Returns the exit status: 0, 1 if a file could not be read or written, 2 for options that do not fit the scene, 128 +
/// the signal that ended it. shared: telemetry in one file with the frames before this one; null: a file of its own.
/// carried: on entry what the previous frame has learned, on return what this one has; null: there are no other frames.
int render_one(const RenderSettings& settings, TelemetryLines* shared, fiber::ModelService* carried);

}  // namespace tress::cli
