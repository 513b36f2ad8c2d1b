// The exits of a row as columns: part by part, and sorted by azimuth within a part.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tress/adaptive/ribbon.h"
#include "tress/adaptive/sampled_target.h"

namespace tress::inline v0_2::adaptive {

/// Exits sorted into equal bins of azimuth; within a bin they keep the order of drawing.
struct RowExits {
  static constexpr std::uint32_t bins = 1024;
  static constexpr std::size_t most_parts = SampledTarget::most_parts, rates = Ribbon::decay_rates.size();
  /// Orders of azimuth whose means a fit keeps, and their cosines and sines.
  static constexpr std::size_t orders = 4, harmonics = 2 * orders;
  /// Columns can be read and written this many floats past their end, and are finite there.
  static constexpr std::size_t padding = 16;

  struct Part {
    double light = 0;                             ///< sum of the weights as drawn
    std::array<double, rates> left{};             ///< the same after absorption, at Ribbon::decay_rates
    double count = 0;                             ///< effective number of exits; 0 if there is no light
    std::array<double, harmonics> directions{};   ///< means of cos x, sin x, cos 2x, sin 2x and so on
    std::array<std::uint32_t, bins + 1> begin{};  ///< first exit of each bin, then the end
  };

  std::uint32_t parts = 0;
  std::array<Part, most_parts> part;
  std::vector<float> x;                         ///< azimuth, radians in [-pi, pi)
  std::vector<float> t;                         ///< height, within two Ribbon::largest_mode of 0
  std::vector<float> w;                         ///< weight, scaled: the weights of a part add up to its count
  std::array<std::vector<float>, rates> decay;  ///< exp(-rate attribute)
  std::vector<std::uint8_t> set;                ///< the set from which it comes; `taught` if it taught an earlier row
  static constexpr std::uint8_t taught = 255;

  std::size_t size() const { return x.size() - padding; }
  /// The azimuth where a bin begins; pi for `bins`.
  static double azimuth(std::uint32_t bin);
};

/// The exits of one set of paths.
struct ExitSet {
  std::span<const SampledExit> exits;
  std::size_t taught = 0;  ///< how many of them, at the beginning, taught an earlier row
};

/// Sorts valid exits (SampledTarget) of parts below `parts`, one set after the other, into memory that is used again.
void sort_exits(std::span<const ExitSet> sets, std::uint32_t parts, RowExits& row);
RowExits sort_exits(std::span<const SampledExit> exits, std::uint32_t parts);  ///< one set

/// Returns every fourth exit of each part that has 2,048 or more, and all exits of the other parts. The first rounds of
/// a fit need no more. Decays are left out, and so are all sums of a part but its count.
RowExits thin_exits(const RowExits& exits);

}  // namespace tress::inline v0_2::adaptive
