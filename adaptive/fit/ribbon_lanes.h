// The ribbons of a row while they are fitted: up to eight problems of one shape, a part and a law of heights each, side
// by side.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "fit/row_exits.h"
#include "tress/adaptive/ribbon.h"

namespace tress::adaptive {

constexpr std::size_t fit_lanes = 2 * RowExits::most_parts;
/// A number of each problem: lane p and lane most_parts + p are of part p.
using Lanes = std::array<float, fit_lanes>;
constexpr std::size_t part_of_lane(std::size_t lane) { return lane % RowExits::most_parts; }

struct alignas(32) KnotLanes {
  Lanes width, hat;  ///< radians to the next knot; the mass of the hat of density 1
  Lanes density, mode, log_below, log_above, scale_below, scale_above;
  /// What is known before any exit: so many exits of the knot's light, and shapes of as many. Every number is read,
  /// that of a shape of no exits too: it must be one.
  Lanes prior_light{}, prior_mode{}, prior_log_below{}, prior_log_above{};
};

template <std::size_t count>
struct LayerLanes {
  std::array<KnotLanes, count> knots;
  std::array<std::array<std::uint32_t, count>, RowExits::most_parts> bin;  ///< where the knots of a part are
  float least_scale;

  static constexpr std::size_t before(std::size_t k) { return k > 0 ? k - 1 : count - 1; }
  static constexpr std::size_t after(std::size_t k) { return k + 1 < count ? k + 1 : 0; }
};
using MainLanes = LayerLanes<Ribbon::main_knots>;
using BroadLanes = LayerLanes<Ribbon::broad_knots>;

/// Exits between two knots of either layer, by number of the knot before them.
struct RibbonPiece {
  std::uint32_t begin, end, main, broad;
  float main_x0, main_inverse_width, broad_x0, broad_inverse_width;  ///< of the azimuth, radians
};

struct RibbonLanes {
  MainLanes main;
  BroadLanes broad;
  Lanes count;                           ///< exits of equal weight
  std::array<HeightLaw, fit_lanes> law;  ///< of the main layer
  std::array<bool, fit_lanes> active;    ///< others are computed and mean nothing
  /// The pieces between any two knots that have exits.
  std::array<std::array<RibbonPiece, Ribbon::main_knots + Ribbon::broad_knots + 1>, RowExits::most_parts> pieces;
  std::array<std::size_t, RowExits::most_parts> piece_count;
};

/// Sums over the exits of a segment of what moves its knots, each over all exits and weighted by s, how far from the
/// first knot to the next they are; r: the layer's share of the density f at an exit.
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

}  // namespace tress::adaptive
