// What a filtered picture says of itself, and how its preview is made.
#pragma once

#include <map>
#include <string>

#include "denoise/half_filter.h"
#include "image/picture.h"
#include "integrate/renderer.h"

namespace tress::cli {

/// The layer of `tress render --denoise`.
inline constexpr const char* denoised_layer = "denoised";

/// With what the header's `alpha` ends where the PNG has alpha too.
inline constexpr const char* alpha_of_png = "; so is the PNG's";

/// Its error, and what it changes.
std::string denoised_words(const denoise::Denoised& filtered);

/// Of the header of a picture of tress: its alpha, exposure and view. What it does not say is as usual.
image::Preview preview_of(const std::map<std::string, std::string>& header);

/// Filters the picture, which must have halves: adds the layer to it and to its header what it is. Error: as of
/// denoise(); nothing is added then. name: of the picture, for errors.
Result<denoise::Denoised> add_denoised(const std::string& name, image::Picture* picture);

/// Of a render that is to end by the noise that is left once its picture is filtered.
class FilteredNoise {
 public:
  /// target: relative; scene: outlives it.
  FilteredNoise(double target, const scene::Scene& scene) : target_(target), scene_(scene) {}

  /// After each pass: the noise once filtered, if this pass is one of those after which it is looked at, which depends
  /// on the pass alone; else a noise above the target.
  double after(const integrate::PassProgress& pass);

 private:
  double target_;
  const scene::Scene& scene_;
  double last_ = 0;  ///< 0: not looked at yet
};

}  // namespace tress::cli
