// What a table is between two passes, as bytes: what state_write.cpp writes and state_read.cpp reads, in this order.
//
//   u32 state_version; text model, text learner
//   totals: u32 pass, u64 paths, reopened, reopened told, queried, f64 mean light of samples, u8 ceiling told, unusable
//     told; u32 number of absorbed errors, each u32 bits, u64 count
//   u32 number of slices, each: text description (as in a cache), u8 has an index, u8 audited;
//     u32 number of nodes that were asked or carry light, each u32 node, u32 queries, u64 light;
//     packed answers, packed stored rows, packed earlier rows; u32 number of forms, each u32 number, u32 nodes made
//   u32 number of slices that nobody uses, each: text, a cache file of its own
//   u32 number of rows in order of creation, each: u32 slice, node, u8 kind, audit and whether it is coarse, u8 failed
//   tests, f32 energy,
//     u32 generation, u64 count, and what its kind has (SavedRow)
//
// text: u32 length, bytes. packed: PackedSlice::write. Little-endian; floats by their bits, a negative zero too.
#pragma once

#include <bit>
#include <cstdint>
#include <string>
#include <string_view>

#include "cache/bytes.h"

namespace tress::adaptive::state_format {

constexpr std::uint32_t state_version = 1;

/// In the byte of Row::audit: Row::is_coarse.
constexpr std::uint8_t coarse_row = 0x80;

/// What answers for a row.
enum class Kind : std::uint8_t { answer = 0, learning = 1, refusal = 2 };

inline void write_text(ByteWriter& out, std::string_view text) {
  out.u32(static_cast<std::uint32_t>(text.size()));
  out.text(text);
}
inline void write_bits(ByteWriter& out, float value) { out.u32(std::bit_cast<std::uint32_t>(value)); }
inline void write_bits(ByteWriter& out, double value) { out.u64(std::bit_cast<std::uint64_t>(value)); }

}  // namespace tress::adaptive::state_format
