// Records of floats, stored field by field, to which whole vectors are appended.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tress::inline v0_2::fiber {

/// field(f)[i] is field f of record i. Every field has room for 16 more floats past its last record, so that whole
/// vectors can be stored of which only the first lanes are used. Plain data; one thread.
class LaneStack {
 public:
  explicit LaneStack(std::size_t fields) : fields_(fields) {}

  std::size_t size() const { return size_; }
  void resize(std::size_t size) { size_ = size; }
  std::size_t stride() const { return stride_; }  ///< distance between the beginnings of two fields
  float* field(std::size_t f) { return floats_.data() + f * stride_; }
  const float* field(std::size_t f) const { return floats_.data() + f * stride_; }
  float at(std::size_t f, std::size_t i) const { return field(f)[i]; }
  std::uint32_t word(std::size_t f, std::size_t i) const { return std::bit_cast<std::uint32_t>(field(f)[i]); }

  /// Makes room for this many more records.
  void reserve(std::size_t more) {
    if (size_ + more + slack <= stride_) return;
    const std::size_t room = (size_ + more + slack + 1023) / 1024 * 1024;
    const std::size_t stride = std::max(room, 2 * stride_) / 1024 * 1024 + slack;  // each in its own cache lines
    std::vector<float> floats(fields_ * stride);
    for (std::size_t f = 0; f < fields_; ++f) std::copy_n(field(f), size_, floats.data() + f * stride);
    floats_ = std::move(floats);
    stride_ = stride;
  }

 private:
  static constexpr std::size_t slack = 16;
  std::size_t fields_, size_ = 0, stride_ = 0;
  std::vector<float> floats_;
};

}  // namespace tress::inline v0_2::fiber
