#include "scene/read/groom_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <iostream>
#include <string>
#include <utility>

#include "scene/read/grooms/groom_formats.h"
#include "scene/read/grooms/pbrt_file.h"
#include "scene/read/grooms/text_cursor.h"
#include "scene/read/input_files.h"
#include "scene/read/mapped_file.h"
#include "scene/read/shared_strands.h"

namespace tress::scene {
namespace {

constexpr std::uintmax_t most_groom_bytes = std::uintmax_t{64} << 30, most_part_bytes = std::uintmax_t{4} << 30;

std::string ending_of(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending;
}

const GroomFormat* format_by_name(const std::filesystem::path& file) {
  const auto formats = groom_formats();
  const auto found = std::ranges::find(formats, ending_of(file), &GroomFormat::ending);
  return found == formats.end() ? nullptr : &*found;
}

std::string wanted() { return "a groom (" + groom_endings() + ")"; }

/// How to convert a file of an unsupported kind into a supported one; empty if there is no way.
std::string remedy_of(const std::string& kind) {
  if (kind.starts_with("an HDF5 file")) return "an Alembic archive of Ogawa (abcconvert -toOgawa IN OUT writes one)";
  if (kind.starts_with("a text in UTF-16")) return "a text in UTF-8 (iconv -f UTF-16 -t UTF-8 IN > OUT writes one)";
  return {};
}

}  // namespace

namespace {

/// Reads standard input to its end.
Result<std::vector<unsigned char>> standard_input() {
  std::vector<unsigned char> bytes;
  constexpr std::size_t block = std::size_t{1} << 20;
  while (std::cin) {
    const std::size_t before = bytes.size();
    bytes.resize(before + block);
    std::cin.read(reinterpret_cast<char*>(bytes.data() + before), static_cast<std::streamsize>(block));
    bytes.resize(before + static_cast<std::size_t>(std::cin.gcount()));
  }
  if (bytes.empty()) return Error{"-", "", wanted(), "nothing on standard input"};
  return bytes;
}

/// Names strands of too few points for a segment, which nothing draws.
void name_short_strands(GroomFile* groom) {
  std::size_t count = 0;
  for (std::uint32_t s = 0; s < groom->strand_count(); ++s)
    if (groom->first_point[s + 1] - groom->first_point[s] < 2 && !std::ranges::binary_search(groom->broken, s)) ++count;
  if (count > 0)
    groom->ignored.push_back(
        {fmt::format("{} of {} strands", count, groom->strand_count()), "they have too few points for a segment"});
}

/// Reads a groom from its bytes. done_with: as in GroomInput.
Result<GroomFile> read_bytes(std::span<const unsigned char> bytes, const std::filesystem::path& file,
                             const DoneWith& done_with, std::optional<std::uint32_t> points_per_strand,
                             std::optional<double> frame, std::optional<double> frames_per_second,
                             const std::string& attribute, const glm::dvec3& origin, bool settles) {
  bytes = without_byte_order_mark(bytes);
  const auto start = bytes.first(std::min(bytes.size(), bytes_of_kind));
  const GroomFormat* format = groom_format_of(bytes);
  if (!format) {
    const std::string ending = ending_of(file);
    const bool is_by_name = known_kind_of(start).empty() || ending == ".hair" || ending == ".usdz";
    format = is_by_name ? format_by_name(file) : nullptr;
    const std::string kind = kind_of(start), remedy = remedy_of(kind);
    if (!format) return Error{file.string(), "byte 0", remedy.empty() ? wanted() : remedy, kind};
    if (!format->mark.empty()) return Error{file.string(), "byte 0", std::string(format->mark), kind_of(start)};
  }
  const auto other_file = [&](const std::string& path) -> Result<std::vector<unsigned char>> {
    const auto other = file.parent_path() / path;
    auto read = read_input_file(other, "a file that the groom includes", most_part_bytes);
    return read ? unpacked(std::move(*read), other.string(), most_part_bytes) : read;
  };
  auto groom = format->read(
      {bytes, file.string(), other_file, points_per_strand, attribute, done_with, frame, frames_per_second, origin});
  if (groom) name_short_strands(&*groom);
  if (groom && settles) settle(&*groom);
  return groom;
}

}  // namespace

Result<GroomFile> read_groom_file(const std::filesystem::path& file, std::optional<std::uint32_t> points_per_strand,
                                  std::optional<double> frame, std::optional<double> frames_per_second,
                                  const std::string& attribute, const glm::dvec3& origin, bool settles) {
  const auto read_unpacked = [&](Result<std::vector<unsigned char>> packed,
                                 const std::filesystem::path& name) -> Result<GroomFile> {
    if (!packed) return packed.error();
    const auto bytes = unpacked(std::move(*packed), name.string(), most_part_bytes);
    if (!bytes) return bytes.error();
    return read_bytes(*bytes, name, {}, points_per_strand, frame, frames_per_second, attribute, origin, settles);
  };
  if (file == "-") return read_unpacked(standard_input(), file);
  const auto mapped = MappedFile::open(file, wanted(), most_groom_bytes);
  if (!mapped) return mapped.error();
  if (is_packed(mapped->bytes()))
    return read_unpacked(read_input_file(file, wanted(), most_part_bytes),
                         ending_of(file) == ".gz" ? file.parent_path() / file.stem() : file);
  const auto done_with = [&](std::span<const unsigned char> part) { mapped->let_go(part); };
  return read_bytes(mapped->bytes(), file, done_with, points_per_strand, frame, frames_per_second, attribute, origin,
                    settles);
}

std::vector<std::filesystem::path> included_files(const std::filesystem::path& file) {
  constexpr std::size_t most = 4096;
  std::vector<std::filesystem::path> files;
  const auto add_those_of = [&](const std::filesystem::path& from) {
    std::vector<unsigned char> packed;
    std::vector<std::string> names;
    if (const auto mapped = MappedFile::open(from, wanted(), most_groom_bytes); mapped && is_packed(mapped->bytes())) {
      const auto bytes = unpacked({mapped->bytes().begin(), mapped->bytes().end()}, from.string(), most_part_bytes);
      if (bytes) names = pbrt_includes(*bytes);
    } else if (mapped) {
      names = pbrt_includes(without_byte_order_mark(mapped->bytes()));
    }
    for (const std::string& name : names)
      if (const auto path = file.parent_path() / name;
          std::ranges::find(files, path) == files.end() && files.size() < most)
        files.push_back(path);
  };
  add_those_of(file);
  for (std::size_t i = 0; i < files.size(); ++i) add_those_of(std::filesystem::path(files[i]));
  return files;
}

bool is_groom_file(const std::filesystem::path& file) {
  if (file == "-" || ending_of(file) == ".hair") return true;
  const auto mapped = MappedFile::open(file, wanted(), most_groom_bytes);
  if (!mapped) return false;
  if (is_packed(mapped->bytes())) return true;
  const auto bytes = without_byte_order_mark(mapped->bytes());
  const std::string known = known_kind_of(bytes.first(std::min(bytes.size(), bytes_of_kind)));
  return groom_format_of(bytes) || !remedy_of(known).empty() || (known.empty() && format_by_name(file));
}

}  // namespace tress::scene
