// The observations that a row keeps: per azimuth bin, the one exact pair nearest to the bin's centre.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "tress/adaptive/cache.h"

namespace tress::inline v0_2::adaptive {

struct ObservedPair {
  float azimuth;  ///< radians in [-pi, pi)
  float g;        ///< 1/rad
};

/// Each bin is 64 bits: |offset| from the centre (31 bits, fixed point), its sign (1 bit), g (32 bits, float). The
/// minimum is the nearest pair, so merging is commutative, associative and idempotent. An empty bin has all bits set.
class Sketch {
 public:
  /// K = max(128, ceil(12 pi / sigma)).
  static std::uint32_t bin_count(float blur_rad);

  explicit Sketch(std::uint32_t bins);

  /// Offers a pair; it is kept if it is the nearest to its bin's centre. Atomic: any thread, and any order gives the
  /// same sketch. x in radians, any turn; g finite, >= 0. The azimuth is quantised first, and g belongs to the
  /// quantised one to 2^-31 of a bin width.
  void offer(float x, float g);
  /// Takes the minimum of each bin. Bins out of range are ignored.
  void merge(const std::vector<SketchBin>& bins);
  std::vector<SketchBin> bins() const;
  /// The pairs, sorted by azimuth. Must not run at the same time as offer().
  std::vector<ObservedPair> pairs() const;
  std::uint32_t occupied() const;
  /// Empties all bins. Must not run at the same time as offer().
  void clear();
  std::size_t bytes() const { return sizeof(*this) + sizeof(std::uint64_t) * bin_count_; }

 private:
  std::uint32_t bin_count_;
  std::unique_ptr<std::atomic<std::uint64_t>[]> bins_;
};

/// Gap fill: every gap d between neighbouring azimuths (circular) wider than 2.5 sigma gets
/// ceil(d / (2.5 sigma)) - 1 equally spaced azimuths; an empty sketch is one gap of 2 pi. Radians in [-pi, pi).
std::vector<float> gap_fill_azimuths(const std::vector<ObservedPair>& pairs, float blur_rad);

}  // namespace tress::inline v0_2::adaptive
