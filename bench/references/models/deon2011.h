// d'Eon, Francois, Hill, Letteri, Aubry 2011, "An Energy-Conserving Hair Reflectance Model", sampled as d'Eon,
// Marschner, Hanika 2013, "Importance Sampling for Physically-Based Hair Fiber Models".
//
// Circular fibers. S = sum_p E_p(theta_r) M_p(theta_i; theta_r) N^_p(phi; theta_d), a density in dtheta_i dphi_i:
//
// M_p is the spherical Gaussian about the specular cone, the published one times cos theta_i
// (energy_conserving_lobe.h).
//
// N^_p is the sum over fixed Gauss-Legendre offsets h of A_p(h) D(phi - Phi_p(h)) over its mass, at |theta_d| of the
// pair: exact Fresnel through eta', absorption along the path, D a wrapped Gaussian (deon2011_azimuth.h).
//
// E_p is the same quadrature of A_p(h), at |theta_d| = |theta_r|.
//
// R, TT, TRT (whole, caustics included: GLINT is always 0) and TRRT are such lobes. All orders above are the residual:
// their summed energy (a circle reflects nothing totally, the geometric series is exact), uniform in azimuth, with M of
// TRRT.
//
// With n points N^_p is a sum of n Gaussians. Where they are narrower than their distances, the azimuth has a spike for
// each: with 10 points under some 7 degrees (figure 8 of Pekelis et al. 2015). That is kept; it is the model.
//
// What differs from the publication:
// - There A_p is taken whole at theta_d, E_p N^_p with E_p(theta_d): reciprocal, but its furnace of clear hair is 1 for
//   narrow lobes only: 0.99 to 1.61 for roughness 0.05 to 0.5 and theta_r up to 88 degrees, with the widths that are
//   stated below (tests/models/deon2011_test.cpp). With E_p at the specular cone it is 1 for any width and number of
//   points.
// - The orders that are traced one by one end at TRRT.
// - Sampling: the publication draws one h at random, a lobe by A_p(h) there, and its weights are those of the lobes at
//   that h. Here the lobe is drawn by the luminance of E_p, theta_i from M_p by the closed inverse, and h is one of the
//   nodes, by the luminance of w_k A_p(h_k): the density of the samples is then the quadrature itself, as a light
//   sample's weight needs it, and S/Q has the same luminance everywhere, that of sum_p E_p.
//
// From FiberParameters: eta; tilts lobe_tilt() (roughness_shift() is our model's own); variance of M_p (4 pi^2/3)
// lambda^2: the logistic of scale lambda has the standard deviation pi lambda/sqrt 3 = 1.81 lambda in theta_h, twice
// that in theta_i, and v is of theta_i. R has that width at every azimuth. Detector: azimuthal_sigmas(); R, which has
// none there, the standard deviation of its theta_i, at most 45 degrees: a rough surface turns reflected light both
// ways alike. sigma_a per radius: that per major semi-axis times r/a, the circle being as wide as the ellipse in the
// mean. longitudinal_shape, reflection_fresnel and split_glint have no meaning here.
#pragma once

#include <memory>

#include "models/registry.h"

namespace tress::inline v0_2::fiber {

/// Points over h where ModelSettings::quadrature_points is 0. They resolve a detector of 2 degrees to 8e-4 (relative L2
/// of N; 35 points one of 3 degrees to 8e-3, 100 one of 1 degree to 0.01: bench_azimuth, TT at theta 20 degrees).
constexpr int deon2011_default_points = 70;

/// Reads settings.quadrature_points.
std::unique_ptr<FiberModel> make_deon2011(const ModelSettings& settings);

}  // namespace tress::inline v0_2::fiber
