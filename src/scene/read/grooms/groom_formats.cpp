#include "scene/read/grooms/groom_formats.h"

#include <algorithm>
#include <array>
#include <string>

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
                [](const GroomInput& input) { return parse_hair_file(input.bytes, input.name); }},
};

}  // namespace

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
