// The formats of strands that can be read, one row each. A new one is a file in this folder and a row here.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "scene/read/grooms/groom_file.h"

namespace tress::scene {

/// An item of a format about curves, time, state or color.
struct FormatItem {
  std::string_view name;
  const char* why;  ///< reason why it is not used; empty if it is, or if it does not affect the picture
};

/// The reason why an item, even one without a row, is not used; empty if it is used.
const char* why_not_used(std::span<const FormatItem> items, std::string_view name);

std::span<const FormatItem> hair_items();
std::span<const FormatItem> usc_data_items();
std::span<const FormatItem> alembic_items();
std::span<const FormatItem> usd_items();
std::span<const FormatItem> usd_instancer_items();
std::span<const FormatItem> pbrt_items();
std::span<const FormatItem> pbrt_curve_items();
std::span<const FormatItem> ply_items();

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

/// Parses the bytes of a .hair file (README.md). `name` is the file named in errors, which give the byte.
Result<GroomFile> parse_hair_file(std::span<const unsigned char> bytes, const std::string& name,
                                  const DoneWith& done_with = {});

// The readers of the other formats.
Result<GroomFile> read_usda(const GroomInput& input);
Result<GroomFile> read_usdc(const GroomInput& input);
Result<GroomFile> read_usdz(const GroomInput& input);
Result<GroomFile> read_alembic(const GroomInput& input);
Result<GroomFile> read_pbrt(const GroomInput& input);
Result<GroomFile> read_usc_data(const GroomInput& input);
Result<GroomFile> read_ply(const GroomInput& input);

/// The names after Include and Import in a scene of pbrt; empty for another file.
std::vector<std::string> pbrt_includes(std::span<const unsigned char> bytes);

/// Whether the bytes have the mark of a USD text, or of a crate.
bool is_usda(std::span<const unsigned char> bytes);
bool is_usdc(std::span<const unsigned char> bytes);
/// Whether a text begins like a scene of pbrt.
bool is_pbrt(std::span<const unsigned char> bytes);
/// Whether the counts of strands and points give exactly the size of the file.
bool is_usc_data(std::span<const unsigned char> bytes);

}  // namespace tress::scene
