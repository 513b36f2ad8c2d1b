// Numbers as binary files have them, little endian, and their conversion to those of a groom.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace tress::scene {

/// The order is that of Ogawa's codes.
enum class NumberFormat : std::uint8_t { boolean, u8, i8, u16, i16, u32, i32, u64, i64, f16, f32, f64 };

std::size_t bytes_of(NumberFormat format);

/// Converts all numbers of the bytes; `out` has room for them. For whole numbers, one that does not fit into 64 bits
/// becomes -1; a double too large for a float becomes infinite. To: float, double or std::int64_t.
template <class To>
void convert_numbers(std::span<const unsigned char> bytes, NumberFormat format, To* out);

}  // namespace tress::scene
