// Little-endian bytes, whatever the machine: explicit shifts, never a struct copied.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

namespace tress::adaptive {

/// Appends integers and floats to a string, lowest byte first.
class ByteWriter {
 public:
  void u8(std::uint8_t value) { bytes_.push_back(static_cast<char>(value)); }
  void u16(std::uint16_t value) { integer(value, 2); }
  void u32(std::uint32_t value) { integer(value, 4); }
  void u64(std::uint64_t value) { integer(value, 8); }
  /// IEEE 754 binary32. A negative zero is written as zero, so that equal values are equal bytes.
  void f32(float value) { u32(value == 0 ? 0u : std::bit_cast<std::uint32_t>(value)); }
  void text(std::string_view value) { bytes_.append(value); }

  const std::string& bytes() const { return bytes_; }
  std::string take() { return std::move(bytes_); }

 private:
  void integer(std::uint64_t value, int size) {
    for (int i = 0; i < size; ++i) bytes_.push_back(static_cast<char>(value >> (8 * i) & 0xff));
  }
  std::string bytes_;
};

/// Reads what ByteWriter wrote. Past the end it returns zeros and remembers: check short_of_bytes() before believing.
class ByteReader {
 public:
  /// `bytes` must outlive the reader. `offset`: position of its first byte in the file.
  explicit ByteReader(std::string_view bytes, std::size_t offset = 0) : bytes_(bytes), offset_(offset) {}

  std::uint8_t u8() { return static_cast<std::uint8_t>(integer(1)); }
  std::uint16_t u16() { return static_cast<std::uint16_t>(integer(2)); }
  std::uint32_t u32() { return static_cast<std::uint32_t>(integer(4)); }
  std::uint64_t u64() { return integer(8); }
  float f32() { return std::bit_cast<float>(u32()); }
  std::string_view text(std::size_t size) {
    if (size > remaining()) {
      short_ = true;
      return {};
    }
    position_ += size;
    return bytes_.substr(position_ - size, size);
  }

  std::size_t remaining() const { return bytes_.size() - position_; }
  /// Of the next byte, in the file.
  std::size_t position() const { return offset_ + position_; }
  bool short_of_bytes() const { return short_; }

 private:
  std::uint64_t integer(std::size_t size) {
    const std::string_view taken = text(size);
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < taken.size(); ++i) {
      value |= static_cast<std::uint64_t>(static_cast<unsigned char>(taken[i])) << (8 * i);
    }
    return value;
  }
  std::string_view bytes_;
  std::size_t offset_;
  std::size_t position_ = 0;
  bool short_ = false;
};

}  // namespace tress::adaptive
