// Which objects the paths of each pixel meet first, and how often.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <vector>

namespace tress::integrate {

/// A pixel has room for a bounded number of objects. One that comes when there is no room is in no count: what all
/// counts of a pixel lack of its covered paths is what was left out. Counts, not sums of floats: the order of samples
/// does not matter but for what is left out, and a pixel's samples come in one order.
///
/// Thread-safety: distinct pixels from distinct threads.
class ObjectCounts {
 public:
  static constexpr std::size_t most_objects = 16;  ///< of a pixel
  static constexpr std::size_t most_strands = 32;  ///< where strands are counted as objects

  struct Count {
    std::uint32_t object = 0;
    std::uint32_t paths = 0;  ///< 0: the room is free, and so is all after it
  };

  /// objects: of the scene, numbered from 0. None: nothing is counted and no memory taken. room: of a pixel.
  ObjectCounts(std::size_t pixels, std::size_t objects, std::size_t room = most_objects)
      : objects_(objects), room_(objects < room ? objects : room), counts_(pixels * room_) {}

  void add(std::size_t pixel, std::uint32_t object, std::uint32_t paths = 1) {
    for (Count& count : std::span(counts_).subspan(pixel * room_, room_)) {
      if (count.paths > 0 && count.object != object) continue;
      count.object = object;
      count.paths += paths;
      return;
    }
  }

  /// Adds the counts of a pixel of the same scene whose paths came after these. False where they may be less than those
  /// of all paths counted one by one: the later ones had no room for an object that has it here.
  bool add(std::size_t pixel, const ObjectCounts& later, std::size_t later_pixel) {
    if (room_ == 0) return true;
    const std::span<const Count> counts = later.of(later_pixel);
    const bool may_lack = objects_ > room_ && counts.back().paths > 0 && of(pixel).front().paths > 0;
    for (const Count& count : counts) {
      if (count.paths > 0) add(pixel, count.object, count.paths);
    }
    return !may_lack;
  }

  /// In the order in which they were met first; free room at the end.
  std::span<const Count> of(std::size_t pixel) const { return std::span(counts_).subspan(pixel * room_, room_); }

  /// All counts as they lie in memory, and back; false if they are not of so many pixels and objects.
  std::string_view bytes() const {
    return {reinterpret_cast<const char*>(counts_.data()), counts_.size() * sizeof(Count)};
  }
  bool set_bytes(std::string_view bytes) {
    if (bytes.size() != counts_.size() * sizeof(Count)) return false;
    if (!bytes.empty()) std::memcpy(counts_.data(), bytes.data(), bytes.size());
    for (const Count& count : counts_) {
      if (count.paths > 0 && count.object >= objects_) return false;
    }
    return true;
  }

 private:
  std::size_t objects_;
  std::size_t room_;
  std::vector<Count> counts_;
};

}  // namespace tress::integrate
