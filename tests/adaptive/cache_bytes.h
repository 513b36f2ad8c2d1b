// Bytes of caches, written over by hand.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "adaptive/cache_images.h"
#include "base/content_hash.h"
#include "cache/byte_source.h"
#include "cache/bytes.h"
#include "cache/format.h"
#include "tress/adaptive/cache.h"

namespace tress::inline v0_2::adaptive {

inline std::size_t get_u64(const std::string& bytes, std::size_t at) {
  const MemoryBytes source(bytes);
  return ByteReader(&source, at, bytes.size() - at).u64();
}

inline void put(std::string* bytes, std::size_t at, std::uint64_t value, int size) {
  for (int i = 0; i < size; ++i) (*bytes)[at + i] = static_cast<char>(value >> (8 * i) & 0xff);
}

inline void put_float(std::string* bytes, std::size_t at, float value) {
  put(bytes, at, std::bit_cast<std::uint32_t>(value), 4);
}

/// First byte of the payload of a section, 1 to 4.
inline std::size_t payload(const std::string& bytes, int section) {
  std::size_t at = format::header_bytes;
  for (int i = 1; i < section; ++i) at += format::section_header_bytes + get_u64(bytes, at + 8);
  return at + format::section_header_bytes;
}

/// Makes the checksum of a section right again, so that only the check of the value can refuse it.
inline void seal(std::string* bytes, int section) {
  const std::size_t start = payload(*bytes, section);
  const std::size_t length = get_u64(*bytes, start - 16);
  put(bytes, start - 8, content_hash(std::string_view(*bytes).substr(start, length)), 8);
}

/// The file of an earlier version: as small_image(), with a row of 32 knots at node 2 of the first slice.
inline std::string knot_cache() {
  std::string bytes = encode_cache(small_image());
  ByteWriter row;
  row.u32(2);
  row.u8(static_cast<std::uint8_t>(RowState::converged));
  row.u8(32);
  row.u8(static_cast<std::uint8_t>(format::Kind::knots));
  row.u8(0);
  row.u32(1);
  row.f32(0.75f);
  row.f32(0.002f);
  row.u64(128);
  for (int i = 0; i < 3 * 32; ++i) row.f32(0.75f / 6.2831853f);
  const std::size_t rows = payload(bytes, 3), length = get_u64(bytes, rows - 16);
  bytes.insert(rows + 4 + 28 + 12 + 2 * 24, row.bytes());
  put(&bytes, rows, 3, 4);
  put(&bytes, rows - 16, length + row.bytes().size(), 8);
  put(&bytes, 8, format::version_of_knots, 4);
  seal(&bytes, 3);
  return bytes;
}

}  // namespace tress::inline v0_2::adaptive
