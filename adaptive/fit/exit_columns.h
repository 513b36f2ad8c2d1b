// The exits of one part, side by side and sorted by azimuth.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tress/adaptive/sampled_target.h"

namespace tress::adaptive {

/// Sorted into equal bins of azimuth, in the order of drawing within a bin.
struct ExitColumns {
  static constexpr std::uint32_t bins = 8192;

  std::vector<float> x;              ///< azimuth, radians in [-pi, pi)
  std::vector<float> t;              ///< height, within two Ribbon::largest_mode of 0
  std::vector<float> w;              ///< weight, as drawn
  std::vector<float> attribute;      ///< each column is followed by zeros, ribbon_lanes of them
  std::vector<std::uint32_t> begin;  ///< of each bin, and the end

  std::size_t size() const { return begin.empty() ? 0 : begin.back(); }
  /// The azimuth where a bin begins; of `bins`, pi.
  static double azimuth(std::uint32_t bin);
};

/// The exits that belong to `part`.
ExitColumns sort_exits(std::span<const SampledExit> exits, std::uint32_t part);

}  // namespace tress::adaptive
