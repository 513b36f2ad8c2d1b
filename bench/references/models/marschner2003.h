// Marschner, Jensen, Cammarano, Worley, Hanrahan 2003, "Light Scattering from Human Hair Fibers" (SIGGRAPH 2003): the
// model that the others start from, as a reference. Faults of its azimuthal part that are kept, and what is bounded or
// read otherwise than printed: marschner_azimuth.h.
//
// f = sum_p M_p(theta_h) N_p(eta'(theta_d); phi)/cos^2 theta_d, p in {R, TT, TRT, GLINT}, and here S = f cos^2 theta_i.
// M_p = 1/2 g(beta_p, theta_h - alpha_p): g, printed without the 1/2, is of mass 1 in theta_h; it stands for the
// delta(theta_i + theta_r) of the smooth fiber, and theta_i + theta_r = 2 theta_h (as printed all is twice as bright).
// It is not normalised over the hemisphere, cos^2 theta_i/cos^2 theta_d does not integrate to 1, and what is put back
// of the caustics is not what was taken out: clear fibers return 0.94 to 1.17 of what meets them for theta_r from 0 to
// 85 degrees, 1.37 at -83, where the tilts help (alpha = 0.2; tests/models/marschner2003_test.cpp, every_model_*).
//
// FiberParameters: alpha_p = lobe_tilt(), beta_p = pi/sqrt(3) longitudinal_lambda() (the standard deviation of that
// logistic), always Gaussian; w_c = azimuthal sigma of TRT, within [2, 45] degrees; eta, e (TRT and GLINT only).
// Delta eta' = 0.3, Delta h_M = 0.5; k_G is the gain of GLINT. sigma_a is per major semi-axis and the paper's circle
// has the mean projected width of the ellipse, so its sigma_a per radius is r/a of it. Sigmas of TT and TRRT, the
// Fresnel variant and the shape of M are not read: R and TT are as sharp as the smooth fiber's. GLINT is part of the
// layer TRT unless the fiber splits it off.
//
// Sampling: the lobe by its energy on the specular cone, a fiftieth of the whole added to each; theta_i from M
// normalised; phi from tables of clear N_p (marschner_table.h). The azimuthal weight is N_p over the tables' density,
// that of theta_i at most 4, its bound being that of cos^2 theta_i/cos^2 theta_d.
#pragma once

#include <memory>

#include "tress/fiber/fiber_model.h"

namespace tress::inline v0_2::fiber {

struct ModelSettings;

/// Reads nothing of the settings.
std::unique_ptr<FiberModel> make_marschner2003(const ModelSettings& settings);

}  // namespace tress::inline v0_2::fiber
