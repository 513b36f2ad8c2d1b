// Little-endian bytes on every machine: made by shifts; no struct is ever copied.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

namespace tress::inline v0_2::adaptive {

/// Appends integers and floats to a string, lowest byte first.
class ByteWriter {
 public:
  void u8(std::uint8_t value) { bytes_.push_back(static_cast<char>(value)); }
  void u32(std::uint32_t value) { integer(value, 4); }
  void u64(std::uint64_t value) { integer(value, 8); }
  /// Writes IEEE 754 binary32. A negative zero is written as zero, so that equal values have equal bytes.
  void f32(float value) { u32(value == 0 ? 0u : std::bit_cast<std::uint32_t>(value)); }
  void text(std::string_view value) { bytes_.append(value); }

  const std::string& bytes() const { return bytes_; }
  std::string take() { return std::move(bytes_); }
  void clear() { bytes_.clear(); }

 private:
  void integer(std::uint64_t value, int size) {
    for (int i = 0; i < size; ++i) bytes_.push_back(static_cast<char>(value >> (8 * i) & 0xff));
  }
  std::string bytes_;
};

}  // namespace tress::inline v0_2::adaptive
