#include "scene/read/grooms/hair_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "scene/read/grooms/groom_builder.h"

namespace tress::scene {
namespace {

static_assert(std::endian::native == std::endian::little, ".hair files are little endian");

constexpr std::size_t header_bytes = 128;
/// Everything that a file can say, by the place where it says it.
constexpr const char* why_opaque = "fibers are as opaque as their absorption";
constexpr FormatItem hair_table[] = {
    {"strands", ""},
    {"points", ""},
    {"segments", ""},
    {"segments of all strands", ""},
    {"thickness", ""},
    {"thickness of all strands", ""},
    {"transparency", why_opaque},
    {"transparency of all strands", why_opaque},
    {"colors", ""},
    {"color of all strands", ""},
    {"remark", ""},
};

constexpr std::uint32_t has_segments = 1, has_points = 2, has_thickness = 4, has_transparency = 8, has_colors = 16;

template <class T>
T read(std::span<const unsigned char> bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

}  // namespace

std::span<const FormatItem> hair_items() { return hair_table; }

Result<GroomFile> parse_hair_file(std::span<const unsigned char> bytes, const std::string& name,
                                  const DoneWith& done_with) {
  const auto error = [&](std::size_t byte, std::string expected, std::string found) {
    return Error{name, fmt::format("byte {}", byte), std::move(expected), std::move(found)};
  };
  if (bytes.empty()) return error(0, "a .hair file", "an empty file");
  if (bytes.size() < 4 || std::memcmp(bytes.data(), "HAIR", 4) != 0)
    return error(0, "\"HAIR\", the mark of a .hair file", "other bytes");
  if (bytes.size() < header_bytes)
    return error(bytes.size(), fmt::format("a header of {} bytes", header_bytes), "the end of the file");

  const std::uint64_t strands = read<std::uint32_t>(bytes, 4), points = read<std::uint32_t>(bytes, 8);
  const auto bits = read<std::uint32_t>(bytes, 12), default_segments = read<std::uint32_t>(bytes, 16);
  if (strands == 0) return error(4, "one strand or more", "0 strands");
  if (points == 0) return error(8, "one point or more", "0 points");
  if (!(bits & has_points)) return error(12, "a file with points (bit 2)", fmt::format("bits {}", bits));
  if (bits & ~31u) return error(12, "no bits but 1, 2, 4, 8, 16", fmt::format("bits {}", bits));
  const std::uint64_t needed = header_bytes + (bits & has_segments ? 2 * strands : 0) + 12 * points +
                               (bits & has_thickness ? 4 * points : 0) + (bits & has_transparency ? 4 * points : 0) +
                               (bits & has_colors ? 12 * points : 0);
  if (needed > bytes.size())
    return error(bytes.size(), fmt::format("{} bytes for {} strands and {} points", needed, strands, points),
                 fmt::format("the end of the file after {}", bytes.size()));
  // Without an array of segments, the number of points bounds the number of strands.
  if (!(bits & has_segments) && strands * (std::uint64_t{default_segments} + 1) != points)
    return error(16, fmt::format("{} strands of equal length to use {} points", strands, points),
                 fmt::format("{} segments each", default_segments));

  GroomFile hair;
  hair.format = "a .hair groom";
  hair.default_width = read<float>(bytes, 20);
  if (!(hair.default_width >= 0 && hair.default_width <= largest_coordinate)) {
    if (!(bits & has_thickness))
      hair.ignored.push_back({"thickness of all strands", "it is negative or no number and taken for none"});
    hair.default_width = 0;
  }
  if (needed < bytes.size())
    hair.ignored.push_back({fmt::format("{} bytes behind the arrays", bytes.size() - needed), "no array is there"});
  hair.parts = {{.name = "", .strands = strands, .points = points}};
  hair.first_point.reserve(strands + 1);
  hair.first_point.push_back(0);
  std::size_t offset = header_bytes;
  std::uint64_t used = 0;
  for (std::uint64_t s = 0; s < strands; ++s) {
    used += std::uint64_t{1} + (bits & has_segments ? read<std::uint16_t>(bytes, offset + 2 * s) : default_segments);
    if (used > points)
      return error(bits & has_segments ? offset + 2 * s : 16, fmt::format("strands of {} points in total", points),
                   fmt::format("strand {} goes on to point {}", s, used));
    hair.first_point.push_back(static_cast<std::uint32_t>(used));
  }
  if (used != points)
    return error(8, fmt::format("the {} points that the segments need", used), fmt::format("{}", points));
  if (bits & has_segments) offset += 2 * strands;

  hair.points.resize(points);
  constexpr std::uint64_t points_a_block = done_block / 12;
  for (std::uint64_t i = 0; i < points; ++i) {
    if (done_with && i % points_a_block == 0 && i > 0)
      done_with(bytes.subspan(offset + 12 * (i - points_a_block), 12 * points_a_block));
    for (int c = 0; c < 3; ++c) {
      const std::size_t byte = offset + 12 * i + 4 * static_cast<std::size_t>(c);
      hair.points[i][c] = read<float>(bytes, byte);
    }
  }
  if (auto broken = leave_out_broken("", 0, &hair)) hair.ignored.push_back(std::move(*broken));
  if (hair.broken.size() == hair.strand_count())
    return error(offset, fmt::format("points that are finite and within {:g}", largest_coordinate),
                 "none in any strand");
  offset += 12 * points;
  if (bits & has_thickness) {
    hair.width.resize(points);
    std::uint64_t wrong = 0;
    for (std::uint64_t i = 0; i < points; ++i) {
      const auto x = read<float>(bytes, offset + 4 * i);
      const bool is_good = x >= 0 && x <= largest_coordinate;
      wrong += is_good ? 0 : 1;
      hair.width[i] = is_good ? x : 0;
    }
    if (wrong > 0)
      hair.ignored.push_back(
          {fmt::format("{} of {} widths", wrong, points), "they are negative or no numbers and taken for 0"});
    if (done_with) done_with(bytes.subspan(offset, 4 * points));
  }
  if (bits & has_thickness) offset += 4 * points;
  if (bits & has_transparency) offset += 4 * points;
  std::uint64_t clamped = 0;
  const auto read_color = [&](std::size_t byte) {
    return clamped_color({read<float>(bytes, byte), read<float>(bytes, byte + 4), read<float>(bytes, byte + 8)},
                         &clamped);
  };
  hair.default_color = read_color(28);
  hair.has_color = (bits & has_colors) != 0 || hair.default_color != glm::vec3(0.0f);
  if (bits & has_colors) {
    clamped = 0;
    hair.color.reserve(points);
    for (std::uint64_t i = 0; i < points; ++i) hair.color.push_back(read_color(offset + 12 * i));
  }
  if (clamped > 0)
    hair.ignored.push_back({fmt::format("{} of {} colors", clamped, bits & has_colors ? points : 1), why_clamped});
  if (bits & has_transparency)
    hair.ignored.push_back({"transparency", why_opaque});
  else if (read<float>(bytes, 24) != 0)
    hair.ignored.push_back({"transparency of all strands", why_opaque});
  return hair;
}

}  // namespace tress::scene
