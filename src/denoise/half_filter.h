// A filter of pictures of hair by their two half pictures (tress render --layers half).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "image/picture.h"
#include "tress/base/error.h"

namespace tress::denoise {

/// Of R, G, B; the numbers are means over the pixels in which something is seen (layer `coverage`; all, of a picture
/// without it). Errors are estimated from the halves alone, within 7 % in pictures of 10,000 pixels and more
/// (bench/README.md, Denoising).
struct Denoised {
  std::array<std::vector<float>, 3> colors;  ///< filtered
  double error_before = 0;                   ///< mean squared error
  double error_after = 0;                    ///< of what is left, blur included; noise of its own may make it negative
  double error_after_deviation = 0;          ///< standard error of error_after, by how squares of pixels differ
  double mean = 0;                           ///< as they were
  double brightness = 0;                     ///< filtered over as they were, minus 1
  double filtered_share = 0;                 ///< 1 all of the filter's, 0 as they were

  /// Root mean square error over the mean, as Film::relative_noise() is of a picture that is not filtered. Never told
  /// smaller than what it can be told from: few pixels may seem to have no error at all.
  double noise() const {
    return mean != 0 ? std::sqrt(std::max(error_after, error_after_deviation)) / std::abs(mean) : 0;
  }
  double noise_before() const { return mean != 0 ? std::sqrt(error_before) / std::abs(mean) : 0; }
};

/// Every pixel becomes a mean of those around it: a Gaussian, long along the tangent of the hair as the picture shows
/// it and narrow across, times how alike their neighbourhoods are in noise's own measure (non-local means; Buades, Coll
/// and Morel 2005, variances and two buffers by Rousselle, Knaus and Zwicker 2012). One half is weighed by the other,
/// so that weights and values err apart. Where the halves tell that the picture as it was is nearer to the truth, it is
/// given back in part or in whole. Deterministic for any number of threads of the calling oneTBB arena.
/// Any finite picture of tress; error: a layer or matrix that it needs is missing, or too few samples to have
/// variances. name: of the file, for errors.
Result<Denoised> denoise(const image::Picture& picture, const std::string& name);

/// The picture with these for its R, G, B, and without the halves and variances, which are of noise that is gone.
image::Picture with_filtered(image::Picture picture, const Denoised& filtered);

}  // namespace tress::denoise
