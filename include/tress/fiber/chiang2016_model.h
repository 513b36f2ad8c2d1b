// Chiang, Bitterli, Tappan, Burley 2016, "A Practical and Controllable Hair and Fur Model for Production Path Tracing".
#pragma once

#include <memory>

#include "tress/fiber/fiber_model.h"

namespace tress::inline v0_2::fiber {

/// The model of today's renderers, such as Blender's Principled Hair. Near field: the azimuth of a circular fiber at
/// the h of the hit, blurred by a logistic that is truncated to the circle. Four lobes: R, TT, TRT and all that follows
/// (Lobe::residual, a geometric series of uniform azimuth). With A_p of the ray at (theta_r, h),
///  S = sum_p A_p M_p N_p,  N_p the truncated logistic about 2 gamma - 2 p gamma_t + p pi.
/// The publication's f = S / cos^2 theta_i; its M is per d(sin theta_i) (src/models/lobes/energy_conserving_lobe.h). In
/// clear hair sum_p A_p is 1, so the furnace is 1 for every h, and S/Q is 1 if drawn lobe by lobe. Not reciprocal.
///
/// Parameters are those of our models, so that pictures compare models with the same settings:
/// - the circle of the same mean projected width replaces the ellipse; sigma_a is scaled to its radius;
/// - variance v_p of M: (2 pi/sqrt 3 longitudinal_lambda)^2, that of our logistic in theta_i; the residual has TRRT's.
///   R's has neither the factor |cos(d/2)| nor roughness_shift(), because the model has neither;
/// - widths are FiberParameters::published_widths if a fiber has them, else those of every model;
/// - logistic scale s_p of N: azimuthal_sigma sqrt 3/pi, of the same standard deviation before truncation. R, which our
///   models do not blur, has that of TT if it is set, as in the publication; else that of its M, so that it is equally
///   rough both ways (alpha sqrt 2, at most 45 degrees);
/// - tilts: M_p about theta_h = lobe_tilt, R towards the root. The publication turns R, TT, TRT by 2, -1, -4 tau in
///   theta_i (ours 2, -1, -3) and leaves the rest untilted;
/// - longitudinal_shape and split_glint have no meaning here, nor has reflection_fresnel, since all orders share F.
///
/// The publication derives all widths from two numbers: v_R = (0.726 b + 0.812 b^2 + 3.7 b^20)^2, v_TT = v_R/4, v_TRT =
/// v_rest = 4 v_R for b = beta_M; one s = sqrt(pi/8) (0.265 b + 1.194 b^2 + 5.372 b^22) for b = beta_N.
std::unique_ptr<FiberModel> make_chiang2016_model();

}  // namespace tress::inline v0_2::fiber
