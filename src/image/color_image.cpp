#include "image/color_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "image/picture.h"

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_NO_STDIO
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_NO_LINEAR
#define STBI_MAX_DIMENSIONS 65536
#include <stb_image.h>

namespace tress::image {
namespace {

constexpr std::uint64_t most_pixels = std::uint64_t{1} << 26;
/// Deflate makes at most 1032 bytes of one, JPEG 64 pixels of some bits.
constexpr std::uint64_t most_pixels_of_a_byte = 8192;

struct Free {
  void operator()(void* memory) const { stbi_image_free(memory); }
};

/// The decoder fills what is missing of a file that was cut off.
bool has_end_of_jpeg(std::span<const unsigned char> bytes) {
  constexpr std::array<unsigned char, 2> end{0xff, 0xd9};
  return std::find_end(bytes.begin(), bytes.end(), end.begin(), end.end()) != bytes.end();
}

/// Width and height as a PNG begins.
std::optional<std::pair<std::uint64_t, std::uint64_t>> png_size(std::span<const unsigned char> bytes) {
  if (bytes.size() < 24 || bytes[0] != 0x89) return std::nullopt;
  const auto number = [&](std::size_t at) {
    return std::uint64_t{bytes[at]} << 24 | std::uint64_t{bytes[at + 1]} << 16 | std::uint64_t{bytes[at + 2]} << 8 |
           bytes[at + 3];
  };
  return std::pair(number(16), number(20));
}

/// Linear values of all that n bits can say.
template <class Value>
std::vector<float> table_of() {
  std::vector<float> table(std::size_t{std::numeric_limits<Value>::max()} + 1);
  for (std::size_t i = 0; i < table.size(); ++i)
    table[i] = linear_from_srgb(static_cast<float>(i) / static_cast<float>(table.size() - 1));
  return table;
}

template <class Value>
void decode(const Value* values, ColorImage* image) {
  const std::vector<float> linear = table_of<Value>();
  for (glm::vec3& pixel : image->pixels)
    for (int c = 0; c < 3; ++c) pixel[c] = linear[*values++];
}

}  // namespace

float linear_from_srgb(float encoded) {
  return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

bool is_png_or_jpeg(std::span<const unsigned char> bytes) {
  constexpr std::array<unsigned char, 8> png{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  constexpr std::array<unsigned char, 3> jpeg{0xff, 0xd8, 0xff};
  const auto begins = [&](const auto& mark) {
    return bytes.size() >= mark.size() && std::equal(mark.begin(), mark.end(), bytes.begin());
  };
  return begins(png) || begins(jpeg);
}

Result<ColorImage> parse_png_or_jpeg(std::span<const unsigned char> bytes, const std::string& name) {
  const auto error = [&](std::string place, std::string expected, std::string found) {
    return Error{name, std::move(place), std::move(expected), std::move(found)};
  };
  if (!is_png_or_jpeg(bytes)) return error("", "a PNG or JPEG picture", "another file");
  if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    return error("", "a picture of at most 2^31 bytes", fmt::format("{}", bytes.size()));
  const auto size = static_cast<int>(bytes.size());
  int width = 0, height = 0, channels = 0;
  const auto why = [] {
    const char* reason = stbi_failure_reason();
    return std::string(reason != nullptr ? reason : "damage");
  };
  const std::uint64_t most = std::min(most_pixels, most_pixels_of_a_byte * bytes.size());
  const auto too_large = [&](std::uint64_t across, std::uint64_t down) -> std::optional<Error> {
    if (across >= 1 && down >= 1 && across <= most && across * down <= most) return std::nullopt;
    return error("size", fmt::format("1 to {} pixels in a file of this size", most),
                 fmt::format("{} x {}", across, down));
  };
  if (const auto claim = png_size(bytes)) {  // of which the decoder would only say that it is no picture
    if (auto refused = too_large(claim->first, claim->second)) return *refused;
  }
  if (stbi_info_from_memory(bytes.data(), size, &width, &height, &channels) == 0)
    return error("header", "a whole PNG or JPEG picture", why());
  if (auto refused =
          too_large(static_cast<std::uint64_t>(std::max(width, 0)), static_cast<std::uint64_t>(std::max(height, 0))))
    return *refused;
  ColorImage image{width, height,
                   std::vector<glm::vec3>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height))};
  if (bytes[0] == 0xff && !has_end_of_jpeg(bytes)) return error("", "a whole JPEG picture", "no mark of its end");
  if (stbi_is_16_bit_from_memory(bytes.data(), size) != 0) {
    const std::unique_ptr<stbi_us, Free> values(
        stbi_load_16_from_memory(bytes.data(), size, &width, &height, &channels, 3));
    if (!values) return error("", "a whole PNG or JPEG picture", why());
    decode(values.get(), &image);
  } else {
    const std::unique_ptr<stbi_uc, Free> values(
        stbi_load_from_memory(bytes.data(), size, &width, &height, &channels, 3));
    if (!values) return error("", "a whole PNG or JPEG picture", why());
    decode(values.get(), &image);
  }
  return image;
}

Result<ColorImage> read_exr_color(const std::filesystem::path& file) {
  const auto picture = read_exr(file);
  if (!picture) return picture.error();
  ColorImage image{picture->width, picture->height, {}};
  const char* const names[3] = {"R", "G", "B"};
  for (int c = 0; c < 3; ++c) {
    const Channel* channel = picture->find(names[c]);
    if (!channel) return Error{file.string(), "channels", "R, G and B", std::string("no ") + names[c]};
    image.pixels.resize(channel->pixels.size());
    for (std::size_t i = 0; i < channel->pixels.size(); ++i) image.pixels[i][c] = channel->pixels[i];
  }
  return image;
}

}  // namespace tress::image
