#include "scene/read/environment_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/ext/vector_double3.hpp>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>

#include "image/color_image.h"
#include "scene/read/input_files.h"

namespace tress::scene {
namespace {

constexpr std::size_t most_pixels = image::most_color_pixels;
constexpr std::uintmax_t most_hdr_bytes = std::uintmax_t{1} << 30;
constexpr float largest_radiance = 1e12f;  ///< its sums and products stay finite in 32 bits

Result<HdrPicture> read_hdr_map(const std::filesystem::path& file) {
  const auto bytes = read_input_file(file, "an HDR picture", most_hdr_bytes);
  if (!bytes) return bytes.error();
  return parse_hdr_file(*bytes, file.string(), most_pixels);
}

Result<HdrPicture> read_exr_map(const std::filesystem::path& file) {
  auto image = image::read_exr_color(file);
  if (!image) return image.error();
  return HdrPicture{image->width, image->height, std::move(image->pixels), std::move(image->remarks)};
}

}  // namespace

Result<Environment> make_environment(HdrPicture map, const std::string& name, double rotate_rad, float scale,
                                     std::vector<std::string>* warnings) {
  const auto width = static_cast<std::size_t>(map.width), count = map.pixels.size();
  for (const std::string& remark : map.remarks) warnings->push_back(name + ": " + remark);
  std::size_t negative = 0;
  for (std::size_t i = 0; i < count; ++i)
    for (int c = 0; c < 3; ++c) {
      float& x = map.pixels[i][c];
      if (!(x <= largest_radiance))
        return Error{name, fmt::format("channel {}, pixel ({}, {})", "RGB"[c], i % width, i / width),
                     fmt::format("a radiance of at most {:g}", largest_radiance), fmt::format("{:g}", x)};
      if (x < 0) ++negative;
      if (!(x > 0)) x = 0;
    }
  if (negative)
    warnings->push_back(fmt::format("{}: {} of {} values are negative and taken for 0", name, negative, 3 * count));
  if (map.width != 2 * map.height)
    warnings->push_back(
        fmt::format("{}: {} x {} is stretched over the sphere; a latitude-longitude map is twice as "
                    "wide as high",
                    name, map.width, map.height));
  return Environment(map.width, map.height, std::move(map.pixels), rotate_rad, scale);
}

Result<Environment> load_environment(const std::filesystem::path& file, double rotate_rad, float scale,
                                     std::vector<std::string>* warnings) {
  const auto start = read_file_start(file, "an EXR or HDR picture", 16);
  if (!start) return start.error();
  if (const std::string kind = known_kind_of(*start);
      !kind.empty() && kind.find("OpenEXR") == kind.npos && kind.find("Radiance") == kind.npos)
    return Error{file.string(), "", "an EXR or HDR picture", kind};
  auto map = is_hdr_file(*start) ? read_hdr_map(file) : read_exr_map(file);
  if (!map) return map.error();
  return make_environment(std::move(*map), file.string(), rotate_rad, scale, warnings);
}

namespace {

using Rgbe = std::array<unsigned char, 4>;

glm::vec3 radiance(const Rgbe& pixel) {
  if (pixel[3] == 0) return glm::vec3(0.0f);
  return glm::vec3(pixel[0], pixel[1], pixel[2]) * std::ldexp(1.0f, pixel[3] - 136);
}

/// Reads forward and keeps the first error.
class HdrReader {
 public:
  HdrReader(std::span<const unsigned char> bytes, const std::string& name) : bytes_(bytes), name_(name) {}

  Error error(std::string expected, std::string found) const {
    return {name_, fmt::format("byte {}", at_), std::move(expected), std::move(found)};
  }
  std::size_t left() const { return bytes_.size() - at_; }

  /// A line of the header without its end; empty if no line of at most 4096 characters ends.
  std::optional<std::string_view> line() {
    std::size_t end = at_;
    while (end < bytes_.size() && end - at_ <= 4096 && bytes_[end] != '\n') ++end;
    if (end == bytes_.size() || bytes_[end] != '\n') return std::nullopt;
    std::string_view text(reinterpret_cast<const char*>(bytes_.data()) + at_, end - at_);
    at_ = end + 1;
    if (!text.empty() && text.back() == '\r') text.remove_suffix(1);
    return text;
  }

  /// Reads one scan line into `row`; an error if it does not fit.
  std::optional<Error> scan_line(std::span<Rgbe> row) {
    const bool encoded = row.size() >= 8 && row.size() < 32768 && left() >= 4 && bytes_[at_] == 2 &&
                         bytes_[at_ + 1] == 2 && bytes_[at_ + 2] < 128;
    return encoded ? by_component(row) : by_pixel(row);
  }

 private:
  Error early() const { return error("more pixels", "the end of the file"); }

  /// Reads four runs of components, each of literal bytes and repetitions.
  std::optional<Error> by_component(std::span<Rgbe> row) {
    const std::size_t width = std::size_t{bytes_[at_ + 2]} << 8 | bytes_[at_ + 3];
    if (width != row.size()) return error(fmt::format("a scan line of {}", row.size()), fmt::format("{}", width));
    at_ += 4;
    for (std::size_t component = 0; component < 4; ++component)
      for (std::size_t column = 0; column < row.size();) {
        if (left() < 2) return early();
        const std::size_t code = bytes_[at_], count = code > 128 ? code - 128 : code;
        if (count == 0 || count > row.size() - column)
          return error(fmt::format("a run of 1..{} pixels", row.size() - column), fmt::format("{}", count));
        ++at_;
        if (left() < (code > 128 ? 1 : count)) return early();
        for (std::size_t i = 0; i < count; ++i) row[column++][component] = bytes_[code > 128 ? at_ : at_ + i];
        at_ += code > 128 ? 1 : count;
      }
    return std::nullopt;
  }

  std::optional<Error> by_pixel(std::span<Rgbe> row) {
    if (left() < 4 * row.size()) return early();
    for (Rgbe& pixel : row) {
      std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(at_), 4, pixel.begin());
      at_ += 4;
    }
    return std::nullopt;
  }

  std::span<const unsigned char> bytes_;
  const std::string& name_;
  std::size_t at_ = 0;
};

/// Divides by a factor of the header; lines of other keys are skipped. False if one is not a number, or if their
/// product is unreasonable.
bool divide_by(std::string_view line, glm::dvec3* scale) {
  constexpr std::string_view exposure = "EXPOSURE=", correction = "COLORCORR=";
  const bool is_exposure = line.starts_with(exposure);
  if (!is_exposure && !line.starts_with(correction)) return true;
  line.remove_prefix(is_exposure ? exposure.size() : correction.size());
  for (int c = 0; c < (is_exposure ? 1 : 3); ++c) {
    line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
    double by = 0;
    const auto [end, code] = std::from_chars(line.data(), line.data() + line.size(), by);
    if (code != std::errc() || !(by > 0)) return false;
    line.remove_prefix(static_cast<std::size_t>(end - line.data()));
    if (is_exposure)
      *scale /= by;
    else
      (*scale)[c] /= by;
  }
  constexpr double most = 1e10;
  for (int c = 0; c < 3; ++c)
    if (!((*scale)[c] >= 1 / most && (*scale)[c] <= most)) return false;
  return true;
}

/// Reads "-Y 512 +X 1024"; false for any other text.
bool read_size(std::string_view line, int* height, int* width) {
  const auto number = [&](std::string_view sign, int* value) {
    if (!line.starts_with(sign)) return false;
    line.remove_prefix(sign.size());
    const auto [end, code] = std::from_chars(line.data(), line.data() + line.size(), *value);
    if (code != std::errc() || *value < 1) return false;
    line.remove_prefix(static_cast<std::size_t>(end - line.data()));
    return true;
  };
  return number("-Y ", height) && number(" +X ", width) && line.empty();
}

}  // namespace

bool is_hdr_file(std::span<const unsigned char> bytes) {
  const std::string_view start(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return start.starts_with("#?RADIANCE") || start.starts_with("#?RGBE");
}

Result<HdrPicture> parse_hdr_file(std::span<const unsigned char> bytes, const std::string& name,
                                  std::size_t most_pixels) {
  HdrReader reader(bytes, name);
  glm::dvec3 scale(1.0);
  if (!is_hdr_file(bytes)) return reader.error("#?RADIANCE", "another start");
  for (auto line = reader.line();; line = reader.line()) {
    if (!line) return reader.error("a line of the header", "none");
    if (line->empty()) break;
    if (!divide_by(*line, &scale))
      return reader.error("EXPOSURE of a number and COLORCORR of three, 1e-10 to 1e10",
                          std::string(line->substr(0, 60)));
    if (line->starts_with("FORMAT=") && *line != "FORMAT=32-bit_rle_rgbe")
      return reader.error("FORMAT=32-bit_rle_rgbe", std::string(line->substr(0, 60)));
  }
  HdrPicture picture;
  const auto size = reader.line();
  if (!size || !read_size(*size, &picture.height, &picture.width))
    return reader.error("a size such as -Y 512 +X 1024", size ? std::string(size->substr(0, 60)) : "none");
  const auto width = static_cast<std::size_t>(picture.width), height = static_cast<std::size_t>(picture.height);
  if (width > most_pixels / height)
    return reader.error(fmt::format("at most {} pixels", most_pixels), fmt::format("{} x {}", width, height));
  // The densest scan line has 8 bytes for 127 pixels.
  if (reader.left() / height * 16 < width)
    return reader.error(fmt::format("{} scan lines of {} pixels", height, width),
                        fmt::format("{} bytes", reader.left()));
  picture.pixels.reserve(width * height);
  std::vector<Rgbe> row(width);
  for (std::size_t y = 0; y < height; ++y) {
    if (auto error = reader.scan_line(row)) return *error;
    for (const Rgbe& pixel : row) {
      const glm::dvec3 scaled = scale * glm::dvec3(radiance(pixel));
      picture.pixels.emplace_back(glm::min(scaled, glm::dvec3(std::numeric_limits<float>::max())));
    }
  }
  if (scale != glm::dvec3(1.0)) picture.remarks.push_back("EXPOSURE and COLORCORR of its header are taken out");
  return picture;
}

}  // namespace tress::scene
