// The formats of strands that can be read, one row each. A new one is a file in this folder and a row here.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "scene/read/grooms/groom_file.h"

namespace tress::scene {

/// An item of a format about curves, time, state or color.
struct FormatItem {
  std::string_view name;
  const char* why;  ///< reason why it is not used; empty if it is, or if it does not affect the picture
};

/// The reason why an item, even one without a row, is not used; empty if it is used.
const char* why_not_used(std::span<const FormatItem> items, std::string_view name);

struct GroomFormat {
  std::string_view name;    ///< "an Alembic archive (Ogawa)"
  std::string_view ending;  ///< ".abc", in small letters
  /// The meaning of the first bytes, for messages: "\"HAIR\", the mark of a .hair file"; empty if there is no mark.
  std::string_view mark;
  /// Whether these are the bytes of such a file, including a damaged one with the right mark. Reads as much as it
  /// needs.
  bool (*is)(std::span<const unsigned char> bytes);
  /// Reads the file. Every count is checked against the number of bytes before memory is allocated. Errors name the
  /// file and the place.
  Result<GroomFile> (*read)(const GroomInput& input);
};

std::span<const GroomFormat> groom_formats();

/// The format of these bytes; null if it is unknown.
const GroomFormat* groom_format_of(std::span<const unsigned char> bytes);

/// ".hair, .abc, .usda", for messages.
std::string groom_endings();

}  // namespace tress::scene
