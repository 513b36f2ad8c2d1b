#include "scene/read/grooms/groom_formats.h"

#include <algorithm>
#include <array>
#include <string>

#include "scene/read/grooms/alembic_file.h"
#include "scene/read/grooms/hair_file.h"
#include "scene/read/grooms/pbrt_file.h"
#include "scene/read/grooms/ply_file.h"
#include "scene/read/grooms/usc_data.h"
#include "scene/read/grooms/usd_file.h"
#include "scene/read/grooms/usd_layer.h"
#include "scene/read/grooms/usdz_file.h"

namespace tress::scene {
namespace {

bool begins(std::span<const unsigned char> bytes, std::string_view mark) {
  return bytes.size() >= mark.size() &&
         std::equal(mark.begin(), mark.end(), bytes.begin(),
                    [](char m, unsigned char b) { return static_cast<unsigned char>(m) == b; });
}

constexpr std::array formats{
    GroomFormat{"a .hair groom", ".hair", "\"HAIR\", the mark of a .hair file",
                [](std::span<const unsigned char> bytes) { return begins(bytes, "HAIR"); },
                [](const GroomInput& input) { return parse_hair_file(input.bytes, input.name, input.done_with); }},
    GroomFormat{"a USD text", ".usda", "\"#usda 1.0\", the mark of a USD text", is_usda, read_usda},
    GroomFormat{"a binary USD file", ".usdc", "\"PXR-USDC\", the mark of a binary USD file", is_usdc, read_usdc},
    GroomFormat{"a USD archive (usdz)", ".usdz", "a zip archive with a layer of USD as its first entry", is_usdz,
                read_usdz},
    GroomFormat{"an Alembic archive (Ogawa)", ".abc", "\"Ogawa\", the mark of an Alembic archive",
                [](std::span<const unsigned char> bytes) { return begins(bytes, "Ogawa"); }, read_alembic},
    GroomFormat{"a pbrt scene", ".pbrt", "", is_pbrt, read_pbrt},
    GroomFormat{"PLY strands", ".ply", "\"ply\", the mark of a PLY file",
                [](std::span<const unsigned char> bytes) { return begins(bytes, "ply\n") || begins(bytes, "ply\r\n"); },
                read_ply},
    GroomFormat{"USC .data strands", ".data", "", is_usc_data, read_usc_data},
};

}  // namespace

const char* why_not_used(std::span<const FormatItem> items, std::string_view name) {
  const auto found = std::ranges::find(items, name, &FormatItem::name);
  return found == items.end() ? "nothing here has a use for it" : found->why;
}

bool is_usda(std::span<const unsigned char> bytes) { return begins(bytes, "#usda "); }
bool is_usdc(std::span<const unsigned char> bytes) { return begins(bytes, "PXR-USDC"); }

std::span<const GroomFormat> groom_formats() { return formats; }

const GroomFormat* groom_format_of(std::span<const unsigned char> bytes) {
  const auto found = std::ranges::find_if(formats, [&](const GroomFormat& format) { return format.is(bytes); });
  return found == formats.end() ? nullptr : &*found;
}

std::string groom_endings() {
  std::string text;
  for (const GroomFormat& format : formats) text += (text.empty() ? "" : ", ") + std::string(format.ending);
  return text;
}

}  // namespace tress::scene
