// What a file is, by its first bytes.
#pragma once

#include <span>
#include <string>

namespace tress::scene {

/// How many bytes kind_of() looks at.
constexpr std::size_t bytes_of_kind = 64;

/// The format that the first bytes of a file are the mark of: "an Alembic archive (Ogawa)", "a PNG picture"; empty
/// where they are none that is known.
std::string known_kind_of(std::span<const unsigned char> start);

/// The same, and where there is no mark what the bytes look like: "a text that begins \"solid\"", "binary data that
/// begins 00 01 02 03". Printable, for messages.
std::string kind_of(std::span<const unsigned char> start);

}  // namespace tress::scene
