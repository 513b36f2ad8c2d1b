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
#define STBI_NO_LINEAR
#define STBI_MAX_DIMENSIONS 65536
#include <stb_image.h>

namespace tress::image {
namespace {

constexpr std::uint64_t most_pixels = std::uint64_t{1} << 26;
/// Deflate makes at most 1032 bytes of one, which are 8 pixels each where a pixel has one bit.
constexpr std::uint64_t most_pixels_of_a_byte = 8256;

struct Free {
  void operator()(void* memory) const { stbi_image_free(memory); }
};

/// Big-endian.
std::uint64_t number_at(std::span<const unsigned char> bytes, std::size_t at) {
  return std::uint64_t{bytes[at]} << 24 | std::uint64_t{bytes[at + 1]} << 16 | std::uint64_t{bytes[at + 2]} << 8 |
         bytes[at + 3];
}

/// Width and height as a PNG begins.
std::optional<std::pair<std::uint64_t, std::uint64_t>> png_size(std::span<const unsigned char> bytes) {
  if (bytes.size() < 24) return std::nullopt;
  return std::pair(number_at(bytes, 16), number_at(bytes, 20));
}

/// Where a chunk of a PNG, up to its last one, is not whole: the decoder takes memory by the length that it says.
std::optional<std::size_t> long_chunk(std::span<const unsigned char> bytes) {
  constexpr std::size_t mark = 8, frame = 12;  // of a chunk: length, type, sum
  for (std::size_t at = mark;;) {
    if (bytes.size() - at < frame) return at;
    const std::uint64_t length = number_at(bytes, at);
    if (length > bytes.size() - at - frame) return at;
    if (number_at(bytes, at + 4) == 0x49454e44) return std::nullopt;  // IEND
    at += frame + static_cast<std::size_t>(length);
  }
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

bool is_png(std::span<const unsigned char> bytes) {
  constexpr std::array<unsigned char, 8> mark{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  return bytes.size() >= mark.size() && std::equal(mark.begin(), mark.end(), bytes.begin());
}

Result<ColorImage> parse_png(std::span<const unsigned char> bytes, const std::string& name) {
  const auto error = [&](std::string place, std::string expected, std::string found) {
    return Error{name, std::move(place), std::move(expected), std::move(found)};
  };
  if (!is_png(bytes)) return error("", "a PNG picture", "another file");
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
  if (const auto place = long_chunk(bytes))
    return error(fmt::format("byte {}", *place), "a whole chunk", "one that is longer than the file");
  if (stbi_info_from_memory(bytes.data(), size, &width, &height, &channels) == 0)
    return error("header", "a whole PNG picture", why());
  if (auto refused =
          too_large(static_cast<std::uint64_t>(std::max(width, 0)), static_cast<std::uint64_t>(std::max(height, 0))))
    return *refused;
  ColorImage image{width, height,
                   std::vector<glm::vec3>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height))};
  if (stbi_is_16_bit_from_memory(bytes.data(), size) != 0) {
    const std::unique_ptr<stbi_us, Free> values(
        stbi_load_16_from_memory(bytes.data(), size, &width, &height, &channels, 3));
    if (!values) return error("", "a whole PNG picture", why());
    decode(values.get(), &image);
  } else {
    const std::unique_ptr<stbi_uc, Free> values(
        stbi_load_from_memory(bytes.data(), size, &width, &height, &channels, 3));
    if (!values) return error("", "a whole PNG picture", why());
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
