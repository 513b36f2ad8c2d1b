// The ribbons of a row during their fit: up to eight problems of one shape side by side. Each problem is a part and a
// law of heights.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "fit/row_exits.h"
#include "tress/adaptive/ribbon.h"

namespace tress::inline v0_2::adaptive {

constexpr std::size_t fit_lanes = 2 * RowExits::most_parts;
/// One number of each problem: lane p and lane most_parts + p belong to part p.
using Lanes = std::array<float, fit_lanes>;
constexpr std::size_t part_of_lane(std::size_t lane) { return lane % RowExits::most_parts; }

struct alignas(32) KnotLanes {
  Lanes width, hat;  ///< radians to the next knot; mass of the hat at density 1
  Lanes density, mode, log_below, log_above, scale_below, scale_above;
  /// The prior, in exits: prior_light exits of the knot's light, and shapes worth as many. The numbers of a shape are
  /// read even where its prior is 0, so they must be valid.
  Lanes prior_light{}, prior_mode{}, prior_log_below{}, prior_log_above{};
};

template <std::size_t count>
struct LayerLanes {
  std::array<KnotLanes, count> knots;
  std::array<std::array<std::uint32_t, count>, RowExits::most_parts> bin;  ///< the bins of the knots of each part
  float least_scale;

  static constexpr std::size_t before(std::size_t k) { return k > 0 ? k - 1 : count - 1; }
  static constexpr std::size_t after(std::size_t k) { return k + 1 < count ? k + 1 : 0; }
};
using MainLanes = LayerLanes<Ribbon::main_knots>;
using BroadLanes = LayerLanes<Ribbon::broad_knots>;

/// The exits between two neighbouring knots of either layer, with the numbers of the knots before them.
struct RibbonPiece {
  std::uint32_t begin, end, main, broad;
  float main_x0, main_inverse_width, broad_x0, broad_inverse_width;  ///< in azimuth, radians
};

struct RibbonLanes {
  MainLanes main;
  BroadLanes broad;
  Lanes count;                           ///< in exits of equal weight
  std::array<HeightLaw, fit_lanes> law;  ///< law of the main layer
  std::array<bool, fit_lanes> active;    ///< inactive ones are computed too, but their values are unused
  /// The pieces between two neighbouring knots that contain exits.
  std::array<std::array<RibbonPiece, Ribbon::main_knots + Ribbon::broad_knots + 1>, RowExits::most_parts> pieces;
  std::array<std::size_t, RowExits::most_parts> piece_count;
};

/// Sums over the exits of a segment, from which its knots move. Each sum is over all exits; `_s` marks one weighted by
/// s, the position from the first knot to the next. r: the layer's share of the density f at an exit.
struct alignas(16) SegmentSums {
  float light = 0, light_s = 0;  ///< w law/f
  float mode = 0, mode_s = 0;    ///< w r times the derivative of ln law
  float scale_below = 0, scale_below_s = 0, scale_above = 0, scale_above_s = 0;
  float information = 0, information_s = 0, information_ss = 0;  ///< w r/(scale_below scale_above)
  float nothing = 0;
};
constexpr std::size_t segment_sums = sizeof(SegmentSums) / sizeof(float);

struct RowSums {
  std::array<std::array<SegmentSums, Ribbon::main_knots>, fit_lanes> main{};
  std::array<std::array<SegmentSums, Ribbon::broad_knots>, fit_lanes> broad{};
};

}  // namespace tress::inline v0_2::adaptive
