#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>

#include "scene/read/input_files.h"

namespace tress::scene {
namespace {

using namespace std::string_view_literals;

struct Mark {
  std::string_view bytes, kind;
};

constexpr std::array marks{
    Mark{"HAIR"sv, "a .hair groom"},
    Mark{"Ogawa"sv, "an Alembic archive (Ogawa)"},
    Mark{"\x89HDF\r\n\x1a\n"sv, "an HDF5 file, as old Alembic archives are"},
    Mark{"PXR-USDC"sv, "a binary USD file"},
    Mark{"#usda "sv, "a USD text"},
    Mark{"glTF"sv, "a binary glTF file"},
    Mark{"Kaydara FBX Binary"sv, "a binary FBX file"},
    Mark{"BLENDER"sv, "a Blender file"},
    Mark{"//Maya"sv, "a Maya text"},
    Mark{"ply\n"sv, "a PLY file"},
    Mark{"\x1f\x8b"sv, "data packed by gzip"},
    Mark{"PK\x03\x04"sv, "a zip archive"},
    Mark{"BZh"sv, "data packed by bzip2"},
    Mark{"\xfd"
         "7zXZ\0"sv,
         "data packed by xz"},
    Mark{"\x28\xb5\x2f\xfd"sv, "data packed by zstd"},
    Mark{"\xff\xfe"sv, "a text in UTF-16, where UTF-8 is read"},
    Mark{"\xfe\xff"sv, "a text in UTF-16, where UTF-8 is read"},
    Mark{"\x89PNG\r\n\x1a\n"sv, "a PNG picture"},
    Mark{"\xff\xd8\xff"sv, "a JPEG picture"},
    Mark{"\x76\x2f\x31\x01"sv, "an OpenEXR picture"},
    Mark{"#?RADIANCE"sv, "a Radiance (HDR) picture"},
    Mark{"#?RGBE"sv, "a Radiance (HDR) picture"},
    Mark{"II*\0"sv, "a TIFF picture"},
    Mark{"MM\0*"sv, "a TIFF picture"},
    Mark{"%PDF"sv, "a PDF document"},
    Mark{"<?xml"sv, "an XML document"},
    Mark{"\x7f"
         "ELF"sv,
         "a program (ELF)"},
};

bool is_printable(unsigned char c) { return c >= ' ' && c <= '~'; }

}  // namespace

std::string known_kind_of(std::span<const unsigned char> start) {
  const std::string_view text(reinterpret_cast<const char*>(start.data()), start.size());
  const auto found = std::ranges::find_if(marks, [&](const Mark& mark) { return text.starts_with(mark.bytes); });
  return found == marks.end() ? "" : std::string(found->kind);
}

std::string kind_of(std::span<const unsigned char> start) {
  if (start.empty()) return "an empty file";
  if (std::string known = known_kind_of(start); !known.empty()) return known;
  start = start.first(std::min(start.size(), bytes_of_kind));
  const auto is_text = [](unsigned char c) {
    return is_printable(c) || c == '\n' || c == '\r' || c == '\t' || c >= 128;
  };
  if (std::ranges::all_of(start, is_text)) {
    std::string word;
    for (unsigned char c : start.first(std::min<std::size_t>(start.size(), 20))) {
      if (c == '\n' || c == '\r') break;
      word += is_printable(c) ? static_cast<char>(c) : '?';
    }
    return fmt::format("a text that begins \"{}\"", word);
  }
  std::string bytes;
  for (unsigned char c : start.first(std::min<std::size_t>(start.size(), 4))) bytes += fmt::format(" {:02x}", c);
  return "binary data that begins" + bytes;
}

}  // namespace tress::scene
