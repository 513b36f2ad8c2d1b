// Reads the .data files of the USC-HairSalon data set and its relatives (README.md).
#include "scene/read/grooms/usc_data.h"

#include <fmt/format.h>

#include <cstring>

#include "scene/read/grooms/groom_builder.h"

namespace tress::scene {
namespace {

/// Everything that a file can say.
constexpr FormatItem usc_data_table[] = {{"strands", ""}, {"points of a strand", ""}, {"points", ""}};

constexpr std::uint64_t point_bytes = 12;

std::int64_t number_at(std::span<const unsigned char> bytes, std::size_t at) {
  std::int32_t value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

}  // namespace

std::span<const FormatItem> usc_data_items() { return usc_data_table; }

bool is_usc_data(std::span<const unsigned char> bytes) {
  if (bytes.size() < 8) return false;
  const std::int64_t strands = number_at(bytes, 0);
  if (strands <= 0 || static_cast<std::uint64_t>(strands) > bytes.size() / 4) return false;
  std::size_t at = 4;
  for (std::int64_t s = 0; s < strands; ++s) {
    if (bytes.size() - at < 4) return false;
    const std::int64_t points = number_at(bytes, at);
    at += 4;
    if (points < 0 || static_cast<std::uint64_t>(points) > (bytes.size() - at) / point_bytes) return false;
    at += static_cast<std::size_t>(points) * point_bytes;
  }
  return at == bytes.size();
}

Result<GroomFile> read_usc_data(const GroomInput& input) {
  const auto bytes = input.bytes;
  const auto error = [&](std::size_t byte, std::string expected, std::string found) {
    return Error{input.name, fmt::format("byte {}", byte), std::move(expected), std::move(found)};
  };
  if (bytes.size() < 4) return error(bytes.size(), "a number of strands", "the end of the file");
  const std::int64_t strands = number_at(bytes, 0);
  const std::size_t most_strands = (bytes.size() - 4) / 4;
  if (strands <= 0 || static_cast<std::uint64_t>(strands) > most_strands)
    return error(0, fmt::format("1 to {} strands, as the bytes allow", most_strands), fmt::format("{}", strands));
  CurveSet set;
  set.kind = {CurveBasis::linear, CurveWrap::nonperiodic};
  set.vertex_counts.reserve(static_cast<std::size_t>(strands));
  set.vertices.reserve((bytes.size() - 4 - 4 * static_cast<std::size_t>(strands)) / point_bytes);
  std::size_t at = 4;
  for (std::int64_t s = 0; s < strands; ++s) {
    if (bytes.size() - at < 4) return error(at, fmt::format("strand {} of {}", s, strands), "the end of the file");
    const std::int64_t points = number_at(bytes, at);
    at += 4;
    if (points < 0 || static_cast<std::uint64_t>(points) > (bytes.size() - at) / point_bytes)
      return error(at - 4,
                   fmt::format("0 to {} points of strand {}, as the bytes allow", (bytes.size() - at) / point_bytes, s),
                   fmt::format("{}", points));
    const std::size_t old = set.vertices.size();
    set.vertices.resize(old + static_cast<std::size_t>(points));
    if (points > 0)
      std::memcpy(set.vertices.data() + old, bytes.data() + at, static_cast<std::size_t>(points) * point_bytes);
    set.vertex_counts.push_back(static_cast<std::uint32_t>(points));
    at += static_cast<std::size_t>(points) * point_bytes;
  }
  if (at != bytes.size())
    return error(at, fmt::format("the end of the file behind {} strands", strands),
                 fmt::format("{} bytes more", bytes.size() - at));
  GroomBuilder builder(input.name, "USC .data strands");
  if (auto fault = builder.add(std::move(set))) return *fault;
  builder.file().basis.reset();
  return builder.finish();
}

}  // namespace tress::scene
