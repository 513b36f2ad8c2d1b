// d'Eon's far-field model of 2022 for round fibers ("A new hair BCSDF for real-time rendering"), as NVIDIA's RTX
// Character Rendering evaluates it (RTXCR Material Library, HairFarFieldBCSDF, MIT license).
#pragma once

#include <glm/vec3.hpp>
#include <memory>

#include "models/registry.h"
#include "references/models/ou2012_lobes.h"

namespace tress::inline v0_2::fiber {

/// Three lobes in closed form. With g(x; w) the Gaussian density of standard deviation w, alpha the roughness, n = eta,
/// tau the tilt of the scales, a = cos theta_d / sqrt(n^2 - sin^2 theta_d) = 1/eta' and F Schlick's Fresnel term,
///   S = 1/2 (M_R N_R + M_TT N_TT + M_TRT N_TRT) cos^2 theta_i / cos^2 theta_d,
///   M_R = g(theta_h + tau; alpha/sqrt 2 max(0.01, cos(phi/2))), N_R = F cos(phi/2) / 4,
///   M_TT = g(theta_h - tau/2; alpha/4 sqrt(n^2 - 1)/cos theta_i), N_TT of the smooth circle (2003), not blurred,
///   M_TRT = g(theta_h - 3 tau/2; alpha/2 (2 + |theta_i|^1.5)), N_TRT three Gaussians fitted to traced paths.
/// The publication's f is S / cos^2 theta_i. Nothing is normalised, and nothing is returned after TRT.
///
/// Sampling is ours: the published one has no density. A lobe is drawn by its energy; theta_h by a Cauchy law as wide
/// as M at theta_i = -theta_r; phi by cos(phi/2) (R), a uniform offset at theta_d = theta_r or, for a tenth of the
/// draws, any azimuth (TT), Cauchy laws in place of the Gaussians (TRT).
///
/// sigma_a is that of a circle of the mean projected width. Widths, longitudinal_shape, reflection_fresnel and
/// roughness_shift() have no meaning here; GLINT is part of TRT.
std::unique_ptr<FiberModel> make_deon2022(const ModelSettings& settings);

/// N_p for p = 1 (TT) and 2 (TRT) with absorption, 1/rad. sigma_a per radius; theta_d and phi in radians, |phi| <= pi.
glm::vec3 deon2022_azimuthal(int p, float eta, float roughness, const glm::vec3& sigma_a, float theta_d, float phi);

/// The laws by which azimuths of TT and TRT are drawn at one theta_d. Plain data.
class Deon2022Draws {
 public:
  Deon2022Draws(float eta, float roughness, float theta_d);
  float density(int p, float phi) const;                  ///< 1/rad, positive
  float sample(int p, float u_phi, float u_other) const;  ///< relative azimuth, [-pi, pi)

 private:
  float a_;  ///< 1/eta'
  AzimuthalBump beside_, middle_;
};

}  // namespace tress::inline v0_2::fiber
