// Writes previews with 8 bits.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "image/picture.h"
#include "image/view_transform.h"
#include "tress/base/replace_file.h"

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#define STBI_WRITE_NO_STDIO
#include <stb_image_write.h>

namespace tress::image {
namespace {

constexpr float mid_grey = 0.18f;

/// Rounds a value in [0, 1] to 8 bits.
std::uint8_t in_8_bits(float value) { return static_cast<std::uint8_t>(std::lround(255 * value)); }

void append_bytes(void* context, void* data, int size) {
  static_cast<std::string*>(context)->append(static_cast<const char*>(data), static_cast<std::size_t>(size));
}

}  // namespace

std::optional<Error> write_png(const std::filesystem::path& file, const Picture& picture, const Preview& preview) {
  const auto pixels =
      static_cast<std::size_t>(std::max(picture.width, 0)) * static_cast<std::size_t>(std::max(picture.height, 0));
  std::string layer = std::string(preview.layer) + ".";
  if (picture.find(layer + "R") == nullptr) layer.clear();
  const Channel* rgb[3] = {picture.find(layer + "R"), picture.find(layer + "G"), picture.find(layer + "B")};
  for (const Channel* channel : rgb)
    if (!channel || channel->pixels.size() != pixels || pixels == 0)
      return Error{file.string(), "channels", "R, G and B of every pixel", "a picture without them"};
  // An opaque preview shows the background of the picture, or mid-grey if it has none.
  const Channel* alpha = preview.alpha || !picture.find("background.R") ? picture.find("A") : nullptr;
  const bool keeps_alpha = preview.alpha && alpha;
  const std::size_t bytes_per_pixel = keeps_alpha ? 4 : 3;
  const auto exposure = static_cast<float>(std::exp2(preview.exposure_stops));
  std::vector<std::uint8_t> bytes;
  bytes.reserve(pixels * bytes_per_pixel);
  for (std::size_t i = 0; i < pixels; ++i) {
    const float covered = alpha ? std::clamp(alpha->pixels[i], 0.0f, 1.0f) : 1.0f;
    const float behind = keeps_alpha ? 0.0f : mid_grey * (1 - covered);
    const float scale = keeps_alpha && covered > 0 ? exposure / covered : exposure;
    const glm::vec3 color(rgb[0]->pixels[i], rgb[1]->pixels[i], rgb[2]->pixels[i]);
    const glm::vec3 shown = displayed(preview.view, scale * color + behind);
    for (int c = 0; c < 3; ++c) bytes.push_back(in_8_bits(shown[c]));
    if (keeps_alpha) bytes.push_back(in_8_bits(covered));
  }
  std::string encoded;
  const int channels = static_cast<int>(bytes_per_pixel);
  if (!stbi_write_png_to_func(append_bytes, &encoded, picture.width, picture.height, channels, bytes.data(),
                              picture.width * channels))
    return Error{file.string(), "", "memory for the PNG encoder", "none left"};
  return replace_file(file, encoded);
}

}  // namespace tress::image
