// Renders many pictures, one frame after the other: finished frames are skipped, and the table is passed from one to
// the next.
#pragma once

#include "cli/render_settings.h"

namespace tress::cli {

/// Returns the exit status of the command. With many frames it is 0 if all pictures exist at the end, and 1 if one
/// could not be rendered; the others are rendered nevertheless.
int run_render(const RenderSettings& settings);

}  // namespace tress::cli
