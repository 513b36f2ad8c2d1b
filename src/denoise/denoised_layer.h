// Adds a filtered picture beside the rendered one, in one file.
#pragma once

#include <string>

#include "denoise/half_filter.h"
#include "image/picture.h"

namespace tress::denoise {

/// The layer of the filtered R, G, B, which previews show (image::Preview::layer).
inline constexpr const char* denoised_layer = "denoised";

/// Smallest number of samples per pixel: two in each half, so that both have a variance.
inline constexpr int least_samples = 4;

/// A text with its error and the change of brightness.
std::string denoised_words(const Denoised& filtered);

/// Filters the picture, which must have halves. Adds the layer, and its description to the header. Error as from
/// denoise(); nothing is then added. name: of the picture, for errors.
Result<Denoised> add_denoised(const std::string& name, image::Picture* picture);

}  // namespace tress::denoise
