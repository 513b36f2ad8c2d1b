#include "scene/read/groom_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string>
#include <utility>

#include "scene/read/grooms/groom_formats.h"
#include "scene/read/input_files.h"
#include "scene/read/mapped_file.h"

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

/// What makes a file that can be read of one that cannot; empty where nothing does.
std::string remedy_of(const std::string& kind) {
  if (kind == "a binary USD file") return "a USD text (usdcat --flatten IN -o OUT.usda writes one)";
  if (kind.starts_with("an HDF5 file")) return "an Alembic archive of Ogawa (abcconvert -toOgawa IN OUT writes one)";
  if (kind == "data packed by gzip") return "a groom that is not packed (gunzip IN)";
  return {};
}

}  // namespace

Result<GroomFile> read_groom_file(const std::filesystem::path& file, std::optional<std::uint32_t> points_per_strand,
                                  std::optional<double> frame, double frames_per_second) {
  const auto mapped = MappedFile::open(file, wanted(), most_groom_bytes);
  if (!mapped) return mapped.error();
  const auto bytes = mapped->bytes();
  const auto start = bytes.first(std::min(bytes.size(), bytes_of_kind));
  const GroomFormat* format = groom_format_of(bytes);
  if (!format) {
    format = known_kind_of(start).empty() || ending_of(file) == ".hair" ? format_by_name(file) : nullptr;
    const std::string kind = kind_of(start), remedy = remedy_of(kind);
    if (!format) return Error{file.string(), "byte 0", remedy.empty() ? wanted() : remedy, kind};
    if (!format->mark.empty()) return Error{file.string(), "byte 0", std::string(format->mark), kind_of(start)};
  }
  const auto other_file = [&](const std::string& path) {
    return read_input_file(file.parent_path() / path, "a file that the groom includes", most_part_bytes);
  };
  const auto done_with = [&](std::span<const unsigned char> part) { mapped->let_go(part); };
  return format->read({bytes, file.string(), other_file, points_per_strand, done_with, frame, frames_per_second});
}

bool is_groom_file(const std::filesystem::path& file) {
  if (ending_of(file) == ".hair") return true;
  const auto mapped = MappedFile::open(file, wanted(), most_groom_bytes);
  if (!mapped) return false;
  const auto bytes = mapped->bytes();
  const std::string known = known_kind_of(bytes.first(std::min(bytes.size(), bytes_of_kind)));
  return groom_format_of(bytes) || !remedy_of(known).empty() || (known.empty() && format_by_name(file));
}

}  // namespace tress::scene
