// The bytes of a table between two passes. state_write.cpp writes them and state_read.cpp reads them, in this order:
//
//   u32 state_version; text model, text learner
//   totals: u32 pass, u64 paths, reopened, reopened that were logged, queried, u8 ceiling logged, unusable
//     logged; u32 number of absorbed errors, each u32 bits, u64 count
//   u32 number of slices, each: text description (as in a cache), u8 has an index, u8 audited;
//     u32 number of nodes that were queried or carry light, each u32 node, u32 queries, u32 events, u64 light;
//     packed answers, packed stored rows, packed earlier rows; u32 number of interpolated nodes, each u32; u64 paths
//     heard, u32 number of nodes with some, each u32 node, u32 number of exits, each f32 azimuth, height, weight,
//     attribute, u8 part; u32 number of forms, each u32 number, u32 nodes made
//   u32 number of unused slices, each: text, a cache file of its own
//   u32 number of rows in order of creation, each: u32 slice, node, u8 kind, u8 audit and whether a row of samples has
//   converged, u8 failed tests, f32 energy,
//     u32 generation, u64 count, and the fields of its kind (SavedRow)
//
// text: u32 length, bytes. packed: PackedSlice::write. All is little-endian; floats are written by their bits, which
// keeps a negative zero.
#pragma once

#include <bit>
#include <cstdint>
#include <string>
#include <string_view>

#include "cache/bytes.h"

namespace tress::adaptive::state_format {

constexpr std::uint32_t state_version = 3;

/// The bit of RibbonAnswer::has_converged in the byte that holds Row::audit.
constexpr std::uint8_t converged_row = 0x80;

/// The kind of answer of a saved row.
enum class Kind : std::uint8_t { answer = 0, learning = 1, refusal = 2 };

inline void write_text(ByteWriter& out, std::string_view text) {
  out.u32(static_cast<std::uint32_t>(text.size()));
  out.text(text);
}
inline void write_bits(ByteWriter& out, float value) { out.u32(std::bit_cast<std::uint32_t>(value)); }
inline void write_bits(ByteWriter& out, double value) { out.u64(std::bit_cast<std::uint64_t>(value)); }

}  // namespace tress::adaptive::state_format
