// Memory for many small things of few sizes.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

namespace tress::inline v0_2::adaptive {

/// Gives out blocks of whole lines, from chunks of `chunk_lines`. Owns every block until it is destroyed. Thread-safe.
template <std::size_t line_bytes, std::size_t chunk_lines>
class BlockStore {
 public:
  /// The bytes that a block of this size takes: whole lines.
  static constexpr std::size_t rounded(std::size_t bytes) { return (bytes + line_bytes - 1) / line_bytes * line_bytes; }

  /// Returns a block. bytes: > 0, from rounded().
  void* take(std::size_t bytes) {
    const std::size_t lines = bytes / line_bytes;
    const std::scoped_lock lock(mutex_);
    if (std::vector<void*>& free = free_[lines]; !free.empty()) {
      void* memory = free.back();
      free.pop_back();
      return memory;
    }
    if (lines > chunk_lines) {
      large_.push_back(std::make_unique<Line[]>(lines));
      return large_.back().get();
    }
    if (used_lines_ + lines > chunk_lines) {
      chunks_.push_back(std::make_unique<Line[]>(chunk_lines));
      used_lines_ = 0;
    }
    void* memory = chunks_.back().get() + used_lines_;
    used_lines_ += lines;
    return memory;
  }
  /// Keeps the block for the next take() of the same size. bytes: as given to take().
  void give_back(void* memory, std::size_t bytes) {
    const std::scoped_lock lock(mutex_);
    free_[bytes / line_bytes].push_back(memory);
  }

 private:
  struct alignas(line_bytes) Line {
    std::byte bytes[line_bytes];
  };
  std::mutex mutex_;
  std::vector<std::unique_ptr<Line[]>> chunks_, large_;
  std::size_t used_lines_ = chunk_lines;            ///< in the last chunk
  std::map<std::size_t, std::vector<void*>> free_;  ///< returned blocks by their number of lines
};

}  // namespace tress::inline v0_2::adaptive
