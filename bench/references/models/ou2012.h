// The artist-friendly lobes of Sadeghi, Pritchett, Jensen, Tamstorf 2010 as Ou, Xie, Krishnamachari, Pellacini 2012
// ("ISHair: Importance Sampling for Hair Scattering") sample them.
#pragma once

#include <memory>

#include "models/registry.h"

namespace tress::inline v0_2::fiber {

/// Four lobes that need no optics: with phi = wrap(phi_i - phi_r) and g(x; w) = e^(-x^2 / 2 w^2), of height 1,
///   S = sum_p C_p g(theta_h - alpha_p; beta_p) N_p(phi) cos^2 theta_i / cos^2 theta_d,
///   N_R = F cos(phi/2), N_TT = g(pi - |phi|; gamma_TT), N_TRT = cos(phi/2), N_GLINT = g(|phi| - G; gamma_G).
/// The publications' f is without cos^2 theta_i (S = f cos^2 theta_i). Nothing is normalised: what a lobe returns
/// depends on inclination and tilt, is cut off at grazing, and nothing is returned after TRT. F is the common Fresnel
/// term that Pekelis et al. 2015 added to R (section 7), here at |theta_d| = |theta_r| as in our own R, of any
/// ReflectionFresnel.
///
/// Sampling, as published: a lobe by its energy; theta_h by a Cauchy law of scale beta_p about alpha_p, cut to the
/// inclinations there are; phi by the cosine, or by Cauchy laws of scale gamma about pi and about +-G. Those are cut to
/// the whole circle here (the publication: to a quarter circle beside their modes), so that the density is positive
/// wherever S is. A weight is about 2 at most, times what the inclination changes.
///
/// Parameters are ours: alpha_p = lobe_tilt(); beta_p = pi/sqrt 3 longitudinal_lambda at theta_r = 0 (a lobe has one
/// width; R's is without its factor |cos(d/2)|). The rest stands for a circular fiber of the mean projected width under
/// light at right angles, so that pictures are as bright as ours there:
/// - C_p makes the untilted lobe return the traced energy of its order under sigma_a: `energy left after full
///   attenuation`, by which Pekelis et al. set it. R has F in its place. TRT's energy is shared with GLINT as ours is;
/// - gamma_TT: the standard deviation of the traced exits of TT, blur included; gamma_G: the blur of TRT;
/// - G: the azimuth of the caustic, 2 gamma - 4 gamma_t at h^2 = (4 - eta^2)/3; 0 for eta >= 2.
/// GLINT is a lobe of the picture where the fiber splits it off, else part of TRT. longitudinal_shape and
/// roughness_shift() have no meaning here.
std::unique_ptr<FiberModel> make_ou2012(const ModelSettings& settings);

}  // namespace tress::inline v0_2::fiber
