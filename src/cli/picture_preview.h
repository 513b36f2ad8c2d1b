// How the preview of a picture is made that says so itself.
#pragma once

#include <map>
#include <string>

#include "image/picture.h"

namespace tress::cli {

/// With what the header's `alpha` ends where the PNG has alpha too.
inline constexpr const char* alpha_of_png = "; so is the PNG's";

/// Of the header of a picture of tress: its alpha, exposure and view. What it does not say is as usual.
image::Preview preview_of(const std::map<std::string, std::string>& header);

}  // namespace tress::cli
