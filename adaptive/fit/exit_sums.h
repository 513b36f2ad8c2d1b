// The loops over exits in which a fit of ribbons spends its time, for the widest instruction set that the machine has.
#pragma once

#include <array>
#include <cstddef>

#include "fit/ribbon_lanes.h"
#include "fit/row_exits.h"

namespace tress::inline v0_2::adaptive {

/// Writes exp(-rate attribute) at both Ribbon::decay_rates; attributes >= 0. The output may be the input. Reads and
/// writes up to RowExits::padding elements past the end.
void write_decays(const float* attributes, std::size_t n, float* first, float* second);

/// Returns the sums over exits [begin, end) of w cos x, w sin x, w cos 2x and so on.
std::array<double, RowExits::harmonics> sum_of_directions(const RowExits& exits, std::size_t begin, std::size_t end);

/// Adds up the exits of the active problems.
void add_exits(const RowExits& exits, const RibbonLanes& lanes, RowSums& sums);

/// Sums of the light of a hat: alone, times heights, and times their squares.
struct alignas(16) HeightSums {
  float light = 0, light_s = 0, height = 0, height_s = 0, square = 0, square_s = 0, nothing[2]{};
};
/// The same for the segments of a part; it does not depend on the law.
struct PartHeights {
  std::array<HeightSums, Ribbon::main_knots> main{};
  std::array<HeightSums, Ribbon::broad_knots> broad{};
};
void add_heights(const RowExits& exits, const RibbonLanes& lanes, std::size_t part, PartHeights& sums);

/// The light of a segment in its layer, clear and after absorption.
struct alignas(16) DecaySums {
  float clear = 0, clear_s = 0, first = 0, first_s = 0, second = 0, second_s = 0, nothing[2]{};
};
struct LaneDecays {
  std::array<DecaySums, Ribbon::main_knots> main{};
  std::array<DecaySums, Ribbon::broad_knots> broad{};
};
void add_decays(const RowExits& exits, const RibbonLanes& lanes, std::size_t lane, LaneDecays& sums);

/// Returns the sum of w ln f over the exits of a problem.
double log_likelihood(const RowExits& exits, const RibbonLanes& lanes, std::size_t lane);

}  // namespace tress::inline v0_2::adaptive
