// The files of bench/lab/web, which are compiled into the program.
#pragma once

#include "live/web_page.h"

namespace tress::lab {

/// Contents by name of the file, "lobes.js".
using live::WebAssets;
const WebAssets& web_assets();

}  // namespace tress::lab
