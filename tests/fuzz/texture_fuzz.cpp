// Any bytes as a PNG: refused, or as many pixels as it says, all in [0, 1].
#include "fuzz/fuzz.h"
#include "image/color_image.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tress;
  const auto image = image::parse_png(fuzz::bytes_of(data, size), "some.png");
  if (!image) {
    fuzz::require_message(image, "some.png");
    return 0;
  }
  fuzz::require(image->pixels.size() ==
                static_cast<std::size_t>(image->width) * static_cast<std::size_t>(image->height));
  for (const glm::vec3& pixel : image->pixels) {
    for (int c = 0; c < 3; ++c) fuzz::require(pixel[c] >= 0 && pixel[c] <= 1);
  }
  return 0;
}
