// The preview settings of a picture, from its header.
#pragma once

#include <map>
#include <string>

#include "image/picture.h"

namespace tress::cli {

/// The end of the header's `alpha` if the PNG has alpha too.
inline constexpr const char* alpha_of_png = "; so is the PNG's";

/// Reads the alpha, exposure and view from the header of a picture of tress; missing values get their defaults.
image::Preview preview_of(const std::map<std::string, std::string>& header);

}  // namespace tress::cli
