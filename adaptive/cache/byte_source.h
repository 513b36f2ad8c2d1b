// Bytes that may hold anything, in memory or in a file, and a window that moves over a range of them.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

namespace tress::inline v0_2::adaptive {

class ByteSource {
 public:
  virtual ~ByteSource() = default;
  virtual std::size_t size() const = 0;
  /// False if the bytes could not be read: the file shrank or has become unreadable.
  virtual bool read(std::size_t offset, char* to, std::size_t size) const = 0;
};

class MemoryBytes final : public ByteSource {
 public:
  /// `bytes` must outlive it.
  explicit MemoryBytes(std::string_view bytes) : bytes_(bytes) {}
  std::size_t size() const override { return bytes_.size(); }
  bool read(std::size_t offset, char* to, std::size_t size) const override {
    if (offset > bytes_.size() || size > bytes_.size() - offset) return false;
    std::memcpy(to, bytes_.data() + offset, size);
    return true;
  }

 private:
  std::string_view bytes_;
};

class FileBytes final : public ByteSource {
 public:
  /// Reads a regular file that stays open and had this size.
  FileBytes(int descriptor, std::size_t size) : descriptor_(descriptor), size_(size) {}
  std::size_t size() const override { return size_; }
  bool read(std::size_t offset, char* to, std::size_t size) const override;

 private:
  int descriptor_;
  std::size_t size_;
};

/// Reads what ByteWriter wrote, from a range of the bytes, through a buffer of at most 32 KB. Past the end it returns
/// zeros and remembers it: check short_of_bytes() before you use the values.
class ByteReader {
 public:
  static constexpr std::size_t largest_buffer = std::size_t{32} << 10;

  ByteReader() = default;
  /// The range must be within the bytes, which must outlive the reader.
  ByteReader(const ByteSource* bytes, std::size_t offset, std::size_t size)
      : bytes_(bytes), next_(offset), end_(offset + size) {}

  std::uint8_t u8() { return static_cast<std::uint8_t>(integer(1)); }
  std::uint32_t u32() { return static_cast<std::uint32_t>(integer(4)); }
  std::uint64_t u64() { return integer(8); }
  float f32() { return std::bit_cast<float>(u32()); }
  /// Returns at most largest_buffer bytes, which are good until the next call.
  std::string_view text(std::size_t size) {
    if (size > buffered() && !fill(size)) {
      short_ = true;
      return {};
    }
    begin_ += size;
    return std::string_view(buffer_).substr(begin_ - size, size);
  }

  std::size_t remaining() const { return buffered() + (end_ - next_); }
  /// The offset of the next byte in the whole file.
  std::size_t position() const { return next_ - buffered(); }
  bool short_of_bytes() const { return short_; }
  /// Whether bytes that are in the range could not be read.
  bool unreadable() const { return unreadable_; }

 private:
  std::size_t buffered() const { return buffer_.size() - begin_; }
  std::uint64_t integer(std::size_t size) {
    const std::string_view taken = text(size);
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < taken.size(); ++i) {
      value |= static_cast<std::uint64_t>(static_cast<unsigned char>(taken[i])) << (8 * i);
    }
    return value;
  }
  bool fill(std::size_t size);

  const ByteSource* bytes_ = nullptr;
  std::size_t next_ = 0, end_ = 0;  ///< the part of the range that is not yet in the buffer
  std::string buffer_;
  std::size_t begin_ = 0;  ///< first byte in the buffer that is not yet read
  bool short_ = false, unreadable_ = false;
};

}  // namespace tress::inline v0_2::adaptive
