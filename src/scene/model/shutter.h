// The time while light falls on a picture.
#pragma once

#include <algorithm>
#include <cstddef>

namespace tress::scene {

/// The time while light falls on the picture, in frames relative to that of the picture; negative before it. Positions
/// of what moves are known at `samples` moments, evenly spaced from opening to closing, and are linear in between.
struct Shutter {
  double open = 0, close = 0;  ///< open <= close
  int samples = 2;             ///< >= 2
  bool is_open() const { return close > open; }
  /// The time of one of the moments, in frames relative to that of the picture.
  double moment(int sample) const { return open + (close - open) * sample / (samples - 1); }
};

/// The position of a time between two of the shutter's evenly spaced moments.
struct BetweenMoments {
  std::size_t before;
  float share;  ///< [0, 1] of the way to the next moment; 0 if there is only one
  /// time: [0, 1], from the opening of the shutter to its closing. moments >= 1.
  BetweenMoments(float time, std::size_t moments) {
    const float along = time * static_cast<float>(moments - 1);
    before = std::min(static_cast<std::size_t>(along), moments < 2 ? 0 : moments - 2);
    share = along - static_cast<float>(before);
  }
};

}  // namespace tress::scene
