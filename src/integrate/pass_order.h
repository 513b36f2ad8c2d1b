// The pixels that a pass samples. They depend only on the pass number, so that no pass depends on what was learned.
#pragma once

#include <cstdint>

namespace tress::integrate {

/// Number of disjoint passes that take sample 0 of a picture: of 1/64, 1/16, 1/4 and 43/64 of the pixels.
constexpr int initial_passes = 4;

/// Rank of a pixel in its 8 x 8 tile, 0..63; each rank occurs once. It interleaves the bits of x ^ y and y as an
/// ordered dither does, so that the first 1, 5, 21 and 64 ranks are spread evenly.
constexpr int rank_in_tile(int x, int y) {
  int rank = 0;
  for (int bit = 0; bit < 3; ++bit) rank = rank << 2 | ((x ^ y) >> bit & 1) << 1 | (y >> bit & 1);
  return rank;
}

/// The pass, 0..3, that takes sample 0 of this pixel.
constexpr int initial_pass(int x, int y) {
  const int rank = rank_in_tile(x & 7, y & 7);
  return rank < 1 ? 0 : rank < 5 ? 1 : rank < 21 ? 2 : 3;
}

/// Number of passes of a picture with `samples` >= 1 per pixel.
constexpr int pass_count(int samples) { return samples + initial_passes - 1; }

/// Index of the sample that a pass takes. All but the first four passes take it of every pixel.
constexpr std::uint32_t sample_of_pass(int pass) {
  return pass < initial_passes ? 0 : static_cast<std::uint32_t>(pass - initial_passes + 1);
}

constexpr bool in_pass(int pass, int x, int y) { return pass >= initial_passes || initial_pass(x, y) == pass; }

}  // namespace tress::integrate
