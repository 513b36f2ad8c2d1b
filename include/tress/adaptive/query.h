// A query as a whole: the look-up of a row, its answer, the density with which it is drawn, and what the row learns.
// At a node, or as the mean over the nodes around a place. Hosts that need more of a row look it up themselves.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "tress/adaptive/row_view.h"
#include "tress/adaptive/service.h"

namespace tress::inline v0_2::adaptive {

struct Node {
  SliceId slice = 0;
  std::uint32_t a = 0, b = 0;  ///< indices into the slice's axes
};

/// The answer at a place of a node.
struct NodeValue {
  float azimuth = 0, height = 0;  ///< the place: radians in [-pi, pi); height 0 in slices of densities
  float density = 0;              ///< by row or target; 1/rad; for samples the sum of the parts, 1/rad/height
  std::array<float, 4> parts{};   ///< for samples, the density of each; otherwise parts[0] is density
  float pdf = 0;                  ///< with which sample() draws the place, same unit
  RowState state = RowState::absent;
  /// False: no row of samples answers here yet, or there is no such slice or node; density, parts and pdf are then 0.
  bool answered = false;
};

// Any thread, during a pass. Uniforms are in [0, 1) and are clamped. Other numbers may be any; those that are not
// finite count as 0, and an infinite a or b as that end of its axis. PassReport::misuse reports slices and nodes that
// do not exist.

/// Draws a place of a node: density / pdf is the weight. Densities use u[0]. An open row is scored.
NodeValue sample(const Service& service, const Node& node, const std::array<float, 3>& u);
/// The same values at a place of the host's. An open row observes it.
NodeValue evaluate(const Service& service, const Node& node, float azimuth, float height = 0);

/// The pdf of evaluate() alone, without a trace: where the row is open or absent, nothing is evaluated or learned, and
/// misuse is not reported.
float pdf(const Service& service, const Node& node, float azimuth, float height = 0);

/// A node around the place (a, b), by coordinates on the slice's axes, chosen by xi such that the mean over xi of
/// anything is its linear interpolation between the nodes. Places beyond the axes are at their ends.
Node choose(const Service& service, SliceId slice, float a, float b, float xi1, float xi2);
/// The mean of evaluate() over the nodes that choose() may give, up to four queries: a pure function of the place. Not
/// answered if one of them is not; the state is that of all, or else of one that has not converged.
NodeValue mean(const Service& service, SliceId slice, float a, float b, float azimuth, float height = 0);
/// Draws from the pdf of mean(), and gives both. u: as for sample(), then xi1, xi2.
NodeValue sample_mean(const Service& service, SliceId slice, float a, float b, const std::array<float, 5>& u);

/// These do the same for as many queries as the shortest of the spans has; values beyond them are not answered.
void sample(const Service& service, std::span<const Node> nodes, std::span<const std::array<float, 3>> u,
            std::span<NodeValue> values);
void evaluate(const Service& service, std::span<const Node> nodes, std::span<const std::array<float, 2>> places,
              std::span<NodeValue> values);

}  // namespace tress::inline v0_2::adaptive
