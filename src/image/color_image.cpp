#include "image/color_image.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <glm/ext/matrix_double3x3.hpp>
#include <glm/ext/vector_double3.hpp>
#include <glm/matrix.hpp>
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
/// Deflate expands a byte to at most 1032 bytes, each of which is 8 pixels if a pixel has one bit.
constexpr std::uint64_t most_pixels_of_a_byte = 8256;

struct Free {
  void operator()(void* memory) const { stbi_image_free(memory); }
};

/// Reads a big-endian number.
std::uint64_t number_at(std::span<const unsigned char> bytes, std::size_t at) {
  return std::uint64_t{bytes[at]} << 24 | std::uint64_t{bytes[at + 1]} << 16 | std::uint64_t{bytes[at + 2]} << 8 |
         bytes[at + 3];
}

/// Width and height from the first bytes of a PNG.
std::optional<std::pair<std::uint64_t, std::uint64_t>> png_size(std::span<const unsigned char> bytes) {
  if (bytes.size() < 24) return std::nullopt;
  return std::pair(number_at(bytes, 16), number_at(bytes, 20));
}

/// The offset of a chunk that reaches beyond the end of a PNG; empty if all chunks are whole. The decoder would
/// allocate the length that the chunk claims.
std::optional<std::size_t> long_chunk(std::span<const unsigned char> bytes) {
  constexpr std::size_t mark = 8, frame = 12;  // frame: length, type and checksum of a chunk
  for (std::size_t at = mark;;) {
    if (bytes.size() - at < frame) return at;
    const std::uint64_t length = number_at(bytes, at);
    if (length > bytes.size() - at - frame) return at;
    if (number_at(bytes, at + 4) == 0x49454e44) return std::nullopt;  // IEND
    at += frame + static_cast<std::size_t>(length);
  }
}

/// Linear values of all numbers of n bits.
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
  if (const auto claim = png_size(bytes)) {  // the decoder's error would not name the size
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

namespace {

std::string in_small_letters(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// The three channels of the color, or the one of grey; empty if it is not clear which they are.
std::vector<std::string> color_channels(const std::vector<std::string>& names) {
  using Triple = std::array<std::string, 3>;
  std::vector<std::pair<std::string, Triple>> layers;  // by their names in lower case; the picture's own color is first
  for (const std::string& name : names) {
    const std::size_t dot = name.rfind('.');
    const std::string layer = dot == name.npos ? "" : name.substr(0, dot + 1), last = name.substr(layer.size());
    for (const auto& [red, green, blue] :
         {Triple{"R", "G", "B"}, Triple{"r", "g", "b"}, Triple{"red", "green", "blue"}, Triple{"Red", "Green", "Blue"}})
      if (last == red && std::ranges::count(names, layer + green) && std::ranges::count(names, layer + blue))
        layers.push_back({in_small_letters(layer), {layer + red, layer + green, layer + blue}});
  }
  const auto one = [&](const auto& is_it) -> const Triple* {
    const auto found = std::ranges::find_if(layers, [&](const auto& layer) { return is_it(layer.first); });
    return found == layers.end() ? nullptr : &found->second;
  };
  const Triple* best = one([](const std::string& layer) { return layer.empty(); });
  for (const char* usual : {"combined", "beauty", "rgba"})
    if (best == nullptr) best = one([&](const std::string& layer) { return layer.find(usual) != layer.npos; });
  if (best == nullptr && layers.size() == 1) best = &layers.front().second;
  if (best != nullptr) return {best->begin(), best->end()};
  for (const char* grey : {"Y", "y", "L"})
    if (std::ranges::count(names, grey) && !std::ranges::count(names, "RY") && layers.empty()) return {grey};
  return {};
}

glm::dmat3 xyz_from(const std::array<float, 8>& c) {
  const auto xyz = [&](std::size_t i) { return glm::dvec3(c[i] / c[i + 1], 1, (1 - c[i] - c[i + 1]) / c[i + 1]); };
  const glm::dmat3 primaries(xyz(0), xyz(2), xyz(4));
  const glm::dvec3 amounts = glm::inverse(primaries) * xyz(6);
  return {primaries[0] * amounts.x, primaries[1] * amounts.y, primaries[2] * amounts.z};
}

constexpr std::array<float, 8> rec709{0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f};

/// The matrix from colors of these chromaticities to Rec. 709; empty if they are the same or invalid.
std::optional<glm::dmat3> to_rec709(const std::array<float, 8>& c) {
  constexpr float rounding = 1e-3f;
  bool is_same = true;
  for (std::size_t i = 0; i < c.size(); ++i) is_same = is_same && std::abs(c[i] - rec709[i]) <= rounding;
  const glm::dmat3 from = xyz_from(c);
  if (is_same || !(std::abs(glm::determinant(from)) > 1e-6) || !std::isfinite(glm::determinant(from)))
    return std::nullopt;
  const glm::dmat3 cones =
      glm::transpose(glm::dmat3(0.8951, 0.2664, -0.1614, -0.7502, 1.7135, 0.0367, 0.0389, -0.0685, 1.0296));
  const glm::dmat3 to = xyz_from(rec709);
  const glm::dvec3 white(1.0), scale = (cones * (to * white)) / (cones * (from * white));
  const glm::dmat3 adapt = glm::inverse(cones) * glm::dmat3(scale.x, 0, 0, 0, scale.y, 0, 0, 0, scale.z) * cones;
  return glm::inverse(to) * adapt * from;
}

/// Replaces infinite values by the largest finite absolute value, with their sign, and NaN by 0. Returns their number.
std::size_t mend(std::vector<glm::vec3>* pixels) {
  float largest = 0;
  for (const glm::vec3& pixel : *pixels)
    for (int c = 0; c < 3; ++c)
      if (std::isfinite(pixel[c])) largest = std::max(largest, std::abs(pixel[c]));
  std::size_t mended = 0;
  for (glm::vec3& pixel : *pixels)
    for (int c = 0; c < 3; ++c) {
      if (std::isfinite(pixel[c])) continue;
      pixel[c] = std::isnan(pixel[c]) ? 0.0f : std::copysign(largest, pixel[c]);
      ++mended;
    }
  return mended;
}

}  // namespace

Result<ColorImage> read_exr_color(const std::filesystem::path& file) {
  std::vector<std::string> chosen;
  const auto picture =
      read_exr_channels(file, [&](const std::vector<std::string>& names) { return chosen = color_channels(names); });
  if (!picture) return picture.error();
  const Window part = picture->window(), whole = picture->whole();
  // A short header must not cause an allocation of any size: beyond a moderate size, the data must fill a share.
  constexpr std::int64_t moderate = std::int64_t{1} << 24, largest_ratio = 64, pixels_of_a_byte = 4096;
  const auto size_error = [&](std::string expected) {
    return Error{file.string(), "header displayWindow", std::move(expected),
                 fmt::format("{} x {}", whole.width, whole.height)};
  };
  std::error_code code;
  const auto bytes = static_cast<std::int64_t>(std::filesystem::file_size(file, code));
  const std::int64_t filled = std::min(largest_ratio * part.width * part.height, pixels_of_a_byte * (code ? 0 : bytes));
  const std::int64_t most = std::min(most_color_pixels, std::max(moderate, filled));
  if (std::int64_t{whole.width} * whole.height > most)
    return size_error(fmt::format("at most {} pixels about {} x {} with data", most, part.width, part.height));
  if (std::max(whole.width, whole.height) > longest_color_side)
    return size_error(fmt::format("sides of at most {} pixels", longest_color_side));
  ColorImage image{whole.width, whole.height, {}};
  image.pixels.assign(static_cast<std::size_t>(whole.width) * static_cast<std::size_t>(whole.height), glm::vec3(0.0f));
  for (std::size_t c = 0; c < 3; ++c) {
    const std::vector<float>& from = picture->find(chosen[std::min(c, chosen.size() - 1)])->pixels;
    for (int y = std::max(part.top, 0); y < std::min(part.top + part.height, whole.height); ++y)
      for (int x = std::max(part.left, 0); x < std::min(part.left + part.width, whole.width); ++x)
        image.pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(whole.width) + static_cast<std::size_t>(x)]
                    [static_cast<int>(c)] =
            from[static_cast<std::size_t>(y - part.top) * static_cast<std::size_t>(part.width) +
                 static_cast<std::size_t>(x - part.left)];
  }
  if (chosen.front() != "R")
    image.remarks.push_back(fmt::format("its color is taken from {}", fmt::join(chosen, ", ")));
  if (const std::size_t mended = mend(&image.pixels))
    image.remarks.push_back(fmt::format("{} of {} values are not finite and taken for the largest that is, NaN for 0",
                                        mended, 3 * image.pixels.size()));
  if (picture->chromaticities && chosen.size() == 3)
    if (const auto convert = to_rec709(*picture->chromaticities)) {
      for (glm::vec3& pixel : image.pixels) pixel = glm::vec3(*convert * glm::dvec3(pixel));
      image.remarks.push_back("its colors are converted from the chromaticities of its header to Rec. 709");
    }
  return image;
}

}  // namespace tress::image
