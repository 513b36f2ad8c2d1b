// Deep pictures: for each pixel, several samples at different depths.
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "image/picture.h"
#include "tress/base/error.h"

namespace tress::image {

/// What a pixel has between two depths. `over`, from the nearest sample to the farthest, makes the pixel.
struct DeepSample {
  glm::vec3 color{0.0f};  ///< linear RGB, premultiplied by alpha
  float alpha = 0;        ///< 0 to 1
  float front_cm = 0;     ///< where it begins: the channel Z
  float back_cm = 0;      ///< where it ends, at least front_cm: ZBack
};

struct DeepPicture {
  std::vector<std::uint32_t> counts;  ///< number of samples of each pixel; row-major, top row first
  std::vector<DeepSample> samples;    ///< of one pixel after the other, each from near to far
};

/// Writes a deep EXR of scanlines with 32 bits for each value, through a temporary file that is renamed. header:
/// its window and metadata are written; its channels are not. Metadata must not be named `version`, which deep
/// files have as a number. It is an error if the counts do not fit the window or the samples, or if a value is not
/// finite.
std::optional<Error> write_deep_exr(const std::filesystem::path& file, const DeepPicture& deep, const Picture& header);

}  // namespace tress::image
