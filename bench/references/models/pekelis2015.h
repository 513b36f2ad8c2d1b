// The paper's own model: Pekelis, Hery, Villemin, Ling 2015, "A Data-Driven Light Scattering Model for Hair", sections
// 3 to 6, as corrected where the printed text cannot be meant (pekelis2015_terms.h names the places; the rows' targets
// and grid: pekelis2015_target.h).
//
//   S = sum_p A_p M_p N_p, densities in dtheta_i dphi_i, p in {R, TT, TRT, GLINT}
//   M_p    logistic in theta_h, normalised over the hemisphere
//   N_R    cosine, sampled as by Hery and Ramamoorthi 2012;  N_TT  logistic about pi, of scale s(theta_D) sigma_TT
//   N_TRT, N_GLINT  mixtures of skew logistics fitted to the functions of Marschner et al. 2003, in rows that the
//          adaptive service learns; a ray is answered by the nearest row, not by interpolation. Until a row has
//          converged its target is the answer. The paper's monomials are left out: they buy nothing. At most 5
//          components for TRT and 3 for GLINT, as the paper (without the limits 18 % of TRT take more, 0.2 % of GLINT).
//   A_p = F_p T_p.  F_R by the angle between the light and the half vector (or as FiberParameters says: figure 5).
//          F_TT, F_TRT by the angle of incidence in three dimensions; gamma(phi) from the cubic's roots, for TRT their
//          mean weighted with their densities, none where no light leaves. F_GLINT at the exact singularity. T by
//          eq. 5.
// Kept of its sources' faults: the targets are Marschner's, with the axes of the ellipse swapped (marschner_azimuth.h);
// R and TT know no ellipse; the furnace is not 1, because energies are taken at the theta_d of each pair:
// 0.96 to 1.01 up to 75 degrees, 1.27 at 85 (alpha = 0.2; tests/models/pekelis2015_test.cpp).
//
// FiberParameters: alpha_p = lobe_tilt(), lambda_p = longitudinal_lambda(), always logistic. sigma_TRT = sigma_GLINT =
// the nearest of 10, 15, 20, 25 degrees to the azimuthal sigma of TRT, e the nearest of 0.85, 0.9, 0.95, 1. sigma_R =
// 1; sigma_TT widens s at the normal plane by the azimuthal sigma of TT. zeta(C): C is the color of light straight
// through the fiber, exp(-2 sigma_a) per radius of the circle of the ellipse's mean projected width. Gains are the
// paper's kappa; that of GLINT is Marschner's k_G. GLINT is part of the layer TRT unless the fiber splits it off.
//
// Lobes are chosen by Marschner's energies (marschner_table.h), which event.energy holds: of the right size, not equal
// to the integral of S. Estimators: `exact` has no rows and reads Marschner's functions at the vertex; `corrected` is
// `fitted` here.
#pragma once

#include <memory>

#include "references/models/pekelis2015_terms.h"
#include "tress/adaptive/target.h"
#include "tress/fiber/fiber_model.h"

namespace tress::inline v0_2::fiber {

struct ModelSettings;

std::unique_ptr<adaptive::Target> make_pekelis2015_target();
/// settings.service: on make_pekelis2015_target(); null for `exact`.
std::unique_ptr<FiberModel> make_pekelis2015(const ModelSettings& settings, PekelisReading reading);

}  // namespace tress::inline v0_2::fiber
