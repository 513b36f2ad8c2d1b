// Counts of the objects that the paths of each pixel meet first.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <vector>

namespace tress::integrate {

/// A pixel has room for a bounded number of objects. Objects that come when there is no room are not counted, so the
/// counts of a pixel may add up to less than its covered paths. The order of samples matters only for which objects are
/// left out, and the samples of a pixel always come in the same order.
///
/// Thread-safety: distinct threads may change distinct pixels.
class ObjectCounts {
 public:
  static constexpr std::size_t most_objects = 16;  ///< room per pixel
  static constexpr std::size_t most_strands = 32;  ///< room per pixel if strands are counted as objects

  struct Count {
    std::uint32_t object = 0;
    std::uint32_t paths = 0;  ///< 0 if this room and all after it are free
  };

  /// objects: number of objects in the scene; with 0, nothing is counted and no memory is used. room: counts per pixel.
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

  /// Adds the counts of a pixel of the same scene whose paths came after these. Returns false if the sum may be less
  /// than counting all paths one by one, because `later` may have had no room for an object that has room here.
  bool add(std::size_t pixel, const ObjectCounts& later, std::size_t later_pixel) {
    if (room_ == 0) return true;
    const std::span<const Count> counts = later.of(later_pixel);
    const bool may_lack = objects_ > room_ && counts.back().paths > 0 && of(pixel).front().paths > 0;
    for (const Count& count : counts) {
      if (count.paths > 0) add(pixel, count.object, count.paths);
    }
    return !may_lack;
  }

  /// The counts of a pixel in the order in which its objects were first met, with free room at the end.
  std::span<const Count> of(std::size_t pixel) const { return std::span(counts_).subspan(pixel * room_, room_); }

  /// All counts as bytes of memory. set_bytes() returns false if they are not of as many pixels and objects.
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
