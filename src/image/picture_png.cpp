// 8 bit previews.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "image/picture.h"
#include "tress/base/replace_file.h"

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#define STBI_WRITE_NO_STDIO
#include <stb_image_write.h>

namespace tress::image {
namespace {

constexpr float mid_grey = 0.18f;

/// Linear to sRGB (IEC 61966-2-1), rounded to 8 bits; outside [0, 1] clamped, NaN to 0.
std::uint8_t encode_srgb(float linear) {
  const float x = linear > 0 ? std::min(linear, 1.0f) : 0.0f;
  const float encoded = x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1 / 2.4f) - 0.055f;
  return static_cast<std::uint8_t>(std::lround(255 * encoded));
}

void append_bytes(void* context, void* data, int size) {
  static_cast<std::string*>(context)->append(static_cast<const char*>(data), static_cast<std::size_t>(size));
}

}  // namespace

std::optional<Error> write_png(const std::filesystem::path& file, const Picture& picture, const Preview& preview) {
  const auto pixels =
      static_cast<std::size_t>(std::max(picture.width, 0)) * static_cast<std::size_t>(std::max(picture.height, 0));
  const Channel* rgb[3] = {picture.find("R"), picture.find("G"), picture.find("B")};
  for (const Channel* channel : rgb)
    if (!channel || channel->pixels.size() != pixels || pixels == 0)
      return Error{file.string(), "channels", "R, G and B of every pixel", "a picture without them"};
  // A picture that carries its background shows it; one of hair alone lies over mid-grey.
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
    for (const Channel* channel : rgb) bytes.push_back(encode_srgb(scale * channel->pixels[i] + behind));
    if (keeps_alpha) bytes.push_back(static_cast<std::uint8_t>(std::lround(255 * covered)));
  }
  std::string encoded;
  const int channels = static_cast<int>(bytes_per_pixel);
  if (!stbi_write_png_to_func(append_bytes, &encoded, picture.width, picture.height, channels, bytes.data(),
                              picture.width * channels))
    return Error{file.string(), "", "memory for the PNG encoder", "none left"};
  return replace_file(file, encoded);
}

}  // namespace tress::image
