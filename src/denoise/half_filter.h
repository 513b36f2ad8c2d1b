// Filters pictures of hair by their two half pictures (tress render --layers half).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "image/picture.h"
#include "tress/base/error.h"

namespace tress::denoise {

/// The filtered R, G, B. Its numbers are means over the pixels in which something is seen (layer `coverage`; all pixels
/// of a picture without it). Errors are estimated from the halves alone, within 7 % in pictures of 10,000 pixels and
/// more (bench/README.md, Denoising).
struct Denoised {
  std::array<std::vector<float>, 3> colors;  ///< filtered
  double error_before = 0;                   ///< mean squared error before filtering
  double error_after = 0;                    ///< mean squared error after filtering; noise may make it negative
  double error_after_deviation = 0;          ///< standard error of error_after, from squares of pixels
  double mean = 0;                           ///< mean of the picture before filtering
  double brightness = 0;                     ///< mean after filtering over mean before, minus 1
  double filtered_share = 0;                 ///< 1: the filter's result; 0: the picture before filtering

  /// Root mean square error over the mean, comparable to Film::relative_noise() of an unfiltered picture. Its standard
  /// error bounds it from below, because in a few pixels the error may seem to be zero.
  double noise() const {
    return mean != 0 ? std::sqrt(std::max(error_after, error_after_deviation)) / std::abs(mean) : 0;
  }
  double noise_before() const { return mean != 0 ? std::sqrt(error_before) / std::abs(mean) : 0; }
};

/// Replaces every pixel by a weighted mean of those around it. The weight is a Gaussian, long along the tangent of the
/// hair in the picture and narrow across, times the likeness of the pixels' neighbourhoods in units of the noise. This
/// is non-local means (Buades, Coll and Morel 2005), with variances and two buffers by Rousselle, Knaus and Zwicker
/// (2012). One half gets its weights from the other, so that the errors of weights and values are independent. Where
/// the halves show that the unfiltered picture is nearer to the truth, it is returned in part or in whole.
/// Deterministic for any number of threads of the calling oneTBB arena. Works on any finite picture of tress. Error if
/// a layer or matrix that it needs is missing, or if there are too few samples for variances. name: the file to name in
/// errors.
Result<Denoised> denoise(const image::Picture& picture, const std::string& name);

/// The picture with these colors as R, G, B, without the halves and variances, which describe the noise before
/// filtering.
image::Picture with_filtered(image::Picture picture, const Denoised& filtered);

}  // namespace tress::denoise
