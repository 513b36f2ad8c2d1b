// A filter of pictures of hair by their two half pictures (tress render --layers half).
#pragma once

#include <string>

#include "image/picture.h"
#include "tress/base/error.h"

namespace tress::denoise {

/// Mean squared errors are over all pixels and channels of R, G, B, and estimated from the halves alone: from how far
/// a filtered half is from the other half, whose noise is its own (cross-validation).
struct Denoised {
  image::Picture picture;     ///< R, G, B filtered; without the halves and the variances, which are not of it
  double error_before = 0;    ///< mean squared error
  double error_after = 0;     ///< what is left, blur included
  double mean = 0;            ///< of R, G, B as they were
  double brightness = 0;      ///< filtered over as they were, minus 1
  double filtered_share = 0;  ///< mean over the pixels: 1 all of the filter's, 0 as they were
};

/// Every pixel becomes a mean of those around it: a Gaussian, long along the tangent of the hair as the picture shows
/// it and narrow across, times how alike their neighbourhoods are in noise's own measure (non-local means; Buades, Coll
/// and Morel 2005, variances and two buffers by Rousselle, Knaus and Zwicker 2012). One half is weighed by the other,
/// so that weights and values err apart. Where the halves tell that the picture as it was is nearer to the truth, it is
/// given back in part or in whole. Deterministic for any number of threads of the calling oneTBB arena.
/// Any finite picture of tress; error: a layer or matrix that it needs is missing, or too few samples to have
/// variances. name: of the file, for errors.
Result<Denoised> denoise(const image::Picture& picture, const std::string& name);

}  // namespace tress::denoise
