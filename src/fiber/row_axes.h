// The grid of a slice's rows: its axes, the symmetries that fold directions onto it, the stochastic choice of a node.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "base/float4.h"
#include "base/quarter_sine.h"
#include "tress/adaptive/mixture.h"
#include "tress/adaptive/target.h"

namespace tress::inline v0_2::fiber {

/// phi_r folded into [0, pi/2] by the symmetries of the ellipse: phi_r -> -phi_r changes the sign of the relative
/// azimuth; phi_r -> phi_r + pi does not.
struct FoldedAzimuth {
  float phi;   ///< radians in [0, pi/2]
  float sign;  ///< +1, or -1 if folding flips the relative azimuth

  /// x = sign (phi_i - phi_r), the relative azimuth that rows store; in [-pi, pi).
  float relative(float phi_i, float phi_r) const { return adaptive::wrap_angle(sign * (phi_i - phi_r)); }
  /// The inverse: phi_i of a row's azimuth x, in [-pi, pi).
  float absolute(float x, float phi_r) const { return adaptive::wrap_angle(phi_r + sign * x); }
};

/// Wraps an angle in [-3 pi, 3 pi) into [-pi, pi), such as a sum or difference of two wrapped angles. Without branches.
inline float wrap_once(float x) {
  constexpr float pi = std::numbers::pi_v<float>;
  x -= x >= pi ? 2 * pi : 0.0f;
  x += x < -pi ? 2 * pi : 0.0f;
  return x < pi ? x : -pi;  // corrects rounding of the line above
}

/// phi_r: radians, any turn.
inline FoldedAzimuth fold_azimuth(float phi_r) {
  constexpr float pi = std::numbers::pi_v<float>;
  const float wrapped = adaptive::wrap_angle(phi_r), a = std::fabs(wrapped);
  const bool beyond = a > pi / 2;
  return {std::clamp(beyond ? pi - a : a, 0.0f, pi / 2), (wrapped < 0) != beyond ? -1.0f : 1.0f};
}

/// The smallest blur for the grid of a slice: 4 degrees. Radians.
constexpr float smallest_grid_sigma = 0.06981317f;
/// Whether a blur is smaller than that. The grid would then have too many rows, so rows serve only as proposals, and g
/// is traced at every vertex. Four degrees in radians may round below the limit and still count as on the grid.
constexpr bool is_below_grid(float sigma_rad) { return sigma_rad < smallest_grid_sigma * (1 - 1e-5f); }

/// The axes of a slice, in radians. axis_a is phi_r, uniform on [0, pi/2] with both ends, in steps of at most sigma/3.
/// It has one node for e = 1, where the relative azimuth does not depend on phi_r. axis_b is |theta_d|, ascending, with
/// 29 nodes: 26 uniform in the cosine from 1 to 0.04, then the cosines 0.02, 0.01 and that of 89.9 degrees.
std::vector<float> azimuth_axis(float eccentricity, float sigma_rad);
std::vector<float> inclination_axis();

/// Chooses nodes of a slice: floor(coordinate + xi) on each axis, such that the expected value of a function of the
/// node is its linear interpolation in phi_r and in cos theta_d. Immutable; any thread.
class RowGrid {
 public:
  /// Copies the axes of an elliptical_slice().
  explicit RowGrid(const adaptive::SliceDescription& slice);

  struct Node {
    std::uint32_t a, b;  ///< indices into axis_a, axis_b
  };
  /// folded_phi in [0, pi/2], theta_d of either sign, xi uniform in [0, 1). Beyond 89.9 degrees it is the last node.
  Node choose(float folded_phi, float theta_d, float xi1, float xi2) const {
    return {choose_azimuth(folded_phi, xi1), choose_inclination(theta_d, xi2)};
  }
  /// The distribution of choose_azimuth() over xi: node `first`, or with the probability `share` the one after it.
  struct Between {
    std::uint32_t first, second;
    float share;  ///< probability of the second node, [0, 1)
  };
  Between between_azimuths(float folded_phi) const { return between(folded_phi * steps_per_radian_, last_a_); }
  Between between_inclinations(float theta_d) const { return between(inclination_coordinate(theta_d), last_b_); }

  /// The two parts of choose(). All slices have the same inclinations, so one choice on that axis serves every lobe.
  std::uint32_t choose_azimuth(float folded_phi, float xi1) const {
    const float at = std::max(folded_phi * steps_per_radian_ + xi1, 0.0f);
    return std::min(static_cast<std::uint32_t>(static_cast<std::int32_t>(at)), last_a_);
  }
  std::uint32_t choose_inclination(float theta_d, float xi2) const {
    const float coordinate = inclination_coordinate(theta_d);
    return std::min(static_cast<std::uint32_t>(static_cast<std::int32_t>(std::max(coordinate, 0.0f) + xi2)), last_b_);
  }

 private:
  float inclination_coordinate(float theta_d) const {
    const Float4 at = from_ + steps_ * (most_ - quarter_cosine(theta_d));
    return std::max(std::max(at[0], at[1]), std::max(at[2], at[3]));
  }
  static Between between(float coordinate, std::uint32_t last) {
    const float at = std::clamp(coordinate, 0.0f, static_cast<float>(last));
    const auto first = static_cast<std::uint32_t>(at);
    return {first, std::min(first + 1, last), at - static_cast<float>(first)};
  }

  std::uint32_t last_a_, last_b_;
  float steps_per_radian_;
  float most_ = quarter_cosine(0);  ///< 1 up to rounding, so that the first node is at 0
  /// The coordinate of axis_b as a function of most_ - cos theta_d is the largest of these straight lines: nodes become
  /// closer towards grazing, in at most four steps.
  Float4 from_ = splat(0), steps_ = splat(0);
};

}  // namespace tress::inline v0_2::fiber
