// Many pictures, one frame after the other: what is finished is skipped, the table goes from one to the next.
#pragma once

#include "cli/render_settings.h"

namespace tress::cli {

/// Exit status of the command. Of many frames: 0 if all are there, 1 if one could not be rendered, the others were.
int run_render(const RenderSettings& settings);

}  // namespace tress::cli
