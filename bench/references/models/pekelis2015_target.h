// What the rows of pekelis2015 are fitted to: N_TRT and N_GLINT of Marschner et al. 2003 on the paper's grid (section
// 6).
//
// The paper's densities are without attenuation, which multiplies them at run time; TRT is without its caustics, GLINT
// is the caustics, of width w_c = sigma. phi_r and theta_D in steps of 2 degrees over [0, 90], sigma 10, 15, 20, 25
// degrees, e .85, .9, .95, 1 (printed "0.5 increments", meant .05): 25,572 rows of each lobe, since e = 1 needs one
// phi_r and 45 theta_D. A row answers all directions nearest to it.
//
// A target is a sum of blurred rays: the curve is given as 720 rays at equal steps, each blurred by 1 degree, half a
// step of the grid. The curves have infinite slopes where TRT ends; what the blur changes of them is a relative squared
// L2 of 2e-5 in the median, 1.5e-3 at 99 %, 4e-3 at most for TRT and less for GLINT
// (tests/models/pekelis2015_test.cpp).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "references/models/marschner_table.h"
#include "tress/adaptive/target.h"

namespace tress::inline v0_2::fiber {

/// The nearest of the grid's values. Radians.
float nearest_pekelis_eccentricity(float eccentricity);
float nearest_pekelis_sigma(float sigma_rad);

/// TRT or GLINT. eccentricity, sigma_rad: of the grid.
adaptive::SliceDescription pekelis_slice(MarschnerLobe lobe, float eta, float eccentricity, float sigma_rad);

/// The row of a slice nearest to folded_phi_r in [0, pi/2] and theta_d of either sign.
struct PekelisNode {
  std::uint32_t a, b;
};
PekelisNode nearest_pekelis_node(const adaptive::SliceDescription& slice, float folded_phi_r, float theta_d);

/// N at a node without attenuation, 1/rad, not blurred: what the paper fits. phi relative, in [-pi, pi].
double pekelis_curve(const adaptive::SliceKey& slice, double phi_r, double theta_d, double phi);

/// Stateless; any thread. Attributes are 0: absorption is eq. 5's.
class PekelisTarget : public adaptive::Target {
 public:
  void trace(const adaptive::SliceDescription& slice, float a, float b,
             std::vector<adaptive::TracedRay>& out) const override;
  std::string model_name() const override { return "pekelis2015-1"; }
};

}  // namespace tress::inline v0_2::fiber
