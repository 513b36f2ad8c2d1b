// The target of the adaptive service for hair: clear rays through the elliptical cross-section, relative to phi_r.
#pragma once

#include "tress/adaptive/target.h"

namespace tress::inline v0_2::fiber {

/// Traces rays of lobe p at (phi_r, |theta_d|): n midpoints in h, n = 128 max(1, 20 degrees / sigma) rounded up to a
/// power of two, and four times as many if E_p < 0.05. Weights are A_p / n, so they sum to E_p; azimuths are Phi_p -
/// phi_r; the attribute is the internal path length in major semi-axes. The parts of TRT get their share of A_2, which
/// depends on the slice's sigma (CrossSection::glint_share). Keys of slices are those of elliptical_slice(): parameters
/// {eta, e, sigma_rad}. (a, b) need not be a node: `exact` traces at the vertex. Stateless; any thread.
class EllipticalTarget : public adaptive::Target {
 public:
  void trace(const adaptive::SliceDescription& slice, float a, float b,
             std::vector<adaptive::TracedRay>& out) const override;
  std::string model_name() const override;
};

/// The n of the rule above, before the factor 4 for weak lobes.
int traced_node_count(float sigma_rad);

}  // namespace tress::inline v0_2::fiber
