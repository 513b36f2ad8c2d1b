#include "image/exr_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <string>
#include <utility>

namespace tress::image {
namespace {

constexpr int longest_name = 255, most_parts = 1024, most_attributes = 65536;
constexpr std::uint32_t magic = 20000630, many_parts = 0x1000;
constexpr std::int64_t most_tile_bytes = std::int64_t{1} << 28;
constexpr std::int64_t rows_of_a_block = 256;  ///< largest number of any compression (DWAB)
constexpr std::uint32_t channel_bytes = 18;    ///< smallest size of the description of a channel
constexpr std::int64_t most_deflated = 1032;   ///< largest number of bytes that deflate makes from one

/// Sizes of the types with a fixed size. OpenEXR reads that many bytes, whatever size the header gives.
constexpr std::array<std::pair<const char*, std::int64_t>, 26> fixed_sizes{{{"box2f", 16},
                                                                            {"box2i", 16},
                                                                            {"chromaticities", 32},
                                                                            {"compression", 1},
                                                                            {"deepImageState", 1},
                                                                            {"double", 8},
                                                                            {"envmap", 1},
                                                                            {"float", 4},
                                                                            {"int", 4},
                                                                            {"keycode", 28},
                                                                            {"lineOrder", 1},
                                                                            {"m33d", 72},
                                                                            {"m33f", 36},
                                                                            {"m44d", 128},
                                                                            {"m44f", 64},
                                                                            {"rational", 8},
                                                                            {"tiledesc", 9},
                                                                            {"timecode", 8},
                                                                            {"v2d", 16},
                                                                            {"v2f", 8},
                                                                            {"v2i", 8},
                                                                            {"v3d", 24},
                                                                            {"v3f", 12},
                                                                            {"v3i", 12},
                                                                            {"v4f", 16},
                                                                            {"v4i", 16}}};

/// Reads little-endian numbers and names until the end of the file.
class HeaderReader {
 public:
  explicit HeaderReader(const std::filesystem::path& file) : in_(file, std::ios::binary) {}

  bool good() const { return in_.good(); }

  std::uint32_t u32() {
    std::array<unsigned char, 4> b{};
    in_.read(reinterpret_cast<char*>(b.data()), b.size());
    return b[0] | std::uint32_t{b[1]} << 8 | std::uint32_t{b[2]} << 16 | std::uint32_t{b[3]} << 24;
  }
  std::int64_t i32() { return static_cast<std::int32_t>(u32()); }

  /// Reads a name up to a zero byte. The stream fails if there is no zero within 255 characters.
  std::string name() {
    std::array<char, longest_name + 1> text{};
    in_.getline(text.data(), text.size(), '\0');
    return text.data();
  }

  std::int64_t place() { return in_.tellg(); }
  void seek(std::int64_t place) { in_.seekg(place); }

 private:
  std::ifstream in_;
};

/// The number of bytes that OpenEXR reads for a value of this type, which begins at the reader. It is `size` where
/// OpenEXR trusts the header, and -1 if OpenEXR would allocate too much memory.
std::int64_t bytes_read(HeaderReader& reader, const std::string& type, std::int64_t size) {
  for (const auto& [name, bytes] : fixed_sizes)
    if (type == name) return bytes;
  const std::int64_t start = reader.place();
  if (type == "chlist") {
    while (!reader.name().empty()) reader.seek(reader.place() + 16);  // type, linearity, sampling
    return reader.good() ? reader.place() - start : -1;
  }
  if (type == "preview") {
    const std::int64_t across = reader.u32(), down = reader.u32();
    return across > size || down > size || across * down > size ? -1 : 8 + 4 * across * down;
  }
  if (type == "idmanifest") return std::int64_t{reader.u32()} > size * most_deflated ? -1 : size;
  return size;
}

/// The values of one part that decide how much OpenEXR allocates.
struct Claims {
  std::int64_t width = 0, height = 0;  ///< 0 without a data window
  std::int64_t tile_width = 0, tile_height = 0;
  std::uint32_t channels = 1;
};

std::optional<Error> check(const Claims& claims, const std::string& file, std::int64_t file_bytes,
                           std::int64_t most_pixels) {
  if (claims.width == 0) return std::nullopt;  // OpenEXR reports a missing data window
  const auto error = [&](const char* attribute, std::string expected, std::int64_t across, std::int64_t down) {
    return Error{file, std::string("header ") + attribute, std::move(expected), fmt::format("{} x {}", across, down)};
  };
  const std::int64_t width = claims.width, height = claims.height;
  if (width < 1 || height < 1 || width > most_pixels || height > most_pixels || width * height > most_pixels)
    return error("dataWindow", fmt::format("1 to {} pixels", most_pixels), width, height);
  std::int64_t blocks = (height + rows_of_a_block - 1) / rows_of_a_block;
  if (claims.tile_width != 0) {
    const std::int64_t across = claims.tile_width, down = claims.tile_height;
    const std::int64_t most_tile = most_tile_bytes / (4 * std::int64_t{claims.channels});
    if (across < 1 || down < 1 || across > most_tile || down > most_tile || across * down > most_tile)
      return error("tiles", fmt::format("1 to {} pixels", most_tile), across, down);
    blocks = ((width + across - 1) / across) * ((height + down - 1) / down);
  }
  if (blocks * std::int64_t{8} > file_bytes)
    return error("dataWindow", fmt::format("a picture of at most {} blocks in a file of this size", file_bytes / 8),
                 width, height);
  return std::nullopt;
}

}  // namespace

std::optional<Error> check_exr_header(const std::filesystem::path& file, std::int64_t most_pixels) {
  std::error_code code;
  const auto file_bytes = static_cast<std::int64_t>(std::filesystem::file_size(file, code));
  HeaderReader reader(file);
  if (code || reader.u32() != magic) return std::nullopt;
  const std::uint32_t version = reader.u32();
  const int parts = (version & many_parts) != 0 ? most_parts : 1;
  int attributes = 0;
  for (int part = 0; part < parts; ++part) {
    Claims claims;
    for (bool first = true;; first = false) {
      const std::string name = reader.name();
      if (!reader.good()) return std::nullopt;  // the header is truncated; OpenEXR reports it
      if (name.empty()) {
        if (first) return std::nullopt;  // the last part was before
        break;
      }
      if (++attributes > most_attributes)
        return Error{file.string(), "header", fmt::format("at most {} attributes", most_attributes), "more"};
      const std::string type = reader.name();
      const std::int64_t size = reader.i32(), place = reader.place();
      if (!reader.good()) return std::nullopt;
      if (size < 0 || size > file_bytes - place)
        return Error{file.string(), "header " + name,
                     fmt::format("a value of at most {} bytes, which is where the file ends", file_bytes - place),
                     fmt::format("{} bytes", size)};
      const std::int64_t read = bytes_read(reader, type, size);
      if (read != size)
        return Error{file.string(), "header " + name,
                     read < 0 ? "a value that fits into the file" : fmt::format("a {} of {} bytes", type, read),
                     fmt::format("{} bytes", size)};
      reader.seek(place);
      if (name == "dataWindow" && type == "box2i") {
        const std::int64_t left = reader.i32(), top = reader.i32();
        claims.width = reader.i32() - left + 1;
        claims.height = reader.i32() - top + 1;
        if (claims.width == 0) claims.width = -1;
      } else if (name == "tiles" && type == "tiledesc") {
        claims.tile_width = reader.u32();
        claims.tile_height = reader.u32();
        if (claims.tile_width == 0) claims.tile_width = -1;
      } else if (name == "channels") {
        claims.channels = std::max<std::uint32_t>(1, static_cast<std::uint32_t>(size) / channel_bytes);
      }
      reader.seek(place + size);
    }
    if (auto error = check(claims, file.string(), file_bytes, most_pixels)) return error;
  }
  return std::nullopt;
}

}  // namespace tress::image
