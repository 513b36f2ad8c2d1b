// A filtered picture beside the one that was rendered, in one file.
#pragma once

#include <string>

#include "denoise/half_filter.h"
#include "image/picture.h"

namespace tress::denoise {

/// The layer of the filtered R, G, B; what previews show (image::Preview::layer).
inline constexpr const char* denoised_layer = "denoised";

/// Fewest samples a pixel: two of each half, to know the variance of both.
inline constexpr int least_samples = 4;

/// Its error, and what it changes.
std::string denoised_words(const Denoised& filtered);

/// Filters the picture, which must have halves: adds the layer to it, and to its header what it is. Error: as of
/// denoise(); nothing is added then. name: of the picture, for errors.
Result<Denoised> add_denoised(const std::string& name, image::Picture* picture);

}  // namespace tress::denoise
