// The grid of a page's rows: its axes, the symmetries that fold onto it, the stochastic choice of a node.
#pragma once

#include <cstdint>
#include <vector>

#include "tress/adaptive/target.h"

namespace tress::fiber {

/// phi_r folded into [0, pi/2] by the symmetries of the ellipse (design section 3): phi_r -> -phi_r changes the sign
/// of the relative azimuth, phi_r -> phi_r + pi leaves it.
struct FoldedAzimuth {
  float phi;   ///< radians in [0, pi/2]
  float sign;  ///< +1, or -1 where folding flips the relative azimuth

  /// x = sign (phi_i - phi_r), the relative azimuth as rows store it; in [-pi, pi).
  float relative(float phi_i, float phi_r) const;
  /// The inverse: phi_i of a row's azimuth x, in [-pi, pi).
  float absolute(float x, float phi_r) const;
};

/// phi_r: radians, any turn.
FoldedAzimuth fold_azimuth(float phi_r);

/// The blur whose grid a page uses: no finer than that of 4 degrees. Radians.
constexpr float smallest_grid_sigma = 0.06981317f;

/// axis_a: phi_r, uniform on [0, pi/2], both ends included, steps of at most sigma/3 (one node for e = 1, where the
/// relative azimuth does not depend on phi_r). axis_b: |theta_d|, ascending: 26 nodes uniform in the cosine from 1 to
/// .04, then the cosines .02, .01 and that of 89.9 degrees: 29 nodes. Radians.
std::vector<float> azimuth_axis(float eccentricity, float sigma_rad);
std::vector<float> inclination_axis();

/// Chooses nodes of a page: floor(coordinate + xi) on each axis, so that on average over xi a function given at the
/// nodes is interpolated linearly, in phi_r and in cos theta_d. Immutable; any thread.
class RowGrid {
 public:
  /// The axes of an elliptical_page(); they are copied.
  explicit RowGrid(const adaptive::PageDescription& page);

  struct Node {
    std::uint32_t a, b;  ///< indices into axis_a, axis_b
  };
  /// folded_phi in [0, pi/2], theta_d of either sign, xi uniform in [0, 1). Beyond 89.9 degrees the last node.
  Node choose(float folded_phi, float theta_d, float xi1, float xi2) const {
    return {choose_azimuth(folded_phi, xi1), choose_inclination(theta_d, xi2)};
  }
  /// Its two halves. All pages have the same inclinations: one choice of that axis serves every lobe.
  std::uint32_t choose_azimuth(float folded_phi, float xi1) const;
  std::uint32_t choose_inclination(float theta_d, float xi2) const;

 private:
  std::uint32_t last_a_, last_b_;
  float steps_per_radian_;
  std::vector<float> cosine_;       ///< of axis_b, descending
  std::vector<float> inverse_gap_;  ///< 1/(cosine[i] - cosine[i + 1])
  float first_gap_inverse_ = 0;     ///< the first of them
};

}  // namespace tress::fiber
