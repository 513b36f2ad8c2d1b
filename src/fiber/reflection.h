// The R lobe: closed form for every eccentricity, sampled by the offset h (design section 3, R).
#pragma once

#include "fiber/longitudinal.h"
#include "fiber/surface_fresnel.h"

namespace tress::fiber {

/// Light reflected at the surface, for one known direction. With d = wrap(phi_i - phi_r) and the normal's azimuth
/// nu = phi_r + d/2, its azimuthal density is F(|cos(d/2)|; theta_r) times the shape
///   1/2 |dh/dphi_i| = 1/4 e^2 cos(d/2) / (w(phi_r) s^3),  s^2 = cos^2 nu + e^2 sin^2 nu:
/// Fresnel and energy both at |theta_d| = |theta_r|: E_R N^_R is energy_density() as it stands, nothing is divided.
/// Azimuths are absolute (from the major axis), radians; densities 1/rad. Not blurred in azimuth.
/// Immutable plain data; any thread.
class ReflectionLobe {
 public:
  /// energy: E_R at (phi_r, theta_r), which chooses how sampling is mixed; any value in [0, 1] gives a sound sampler.
  /// tilt, lambda: of the longitudinal lobe in theta_h; lambda is before the factor |cos(d/2)|.
  ReflectionLobe(float eta, float eccentricity, float theta_r, float phi_r, float energy, float tilt, float lambda,
                 ReflectionFresnel fresnel = ReflectionFresnel::exact,
                 LongitudinalShape longitudinal_shape = LongitudinalShape::logistic);

  /// Everything at one phi_i, in one pass over its geometry.
  struct At {
    float energy_density, azimuth_pdf;
    float lambda;  ///< of M here
  };
  At at(float phi_i) const;
  /// M there, 1/rad: longitudinal(phi_i).density(theta_i).
  float longitudinal_density(const At& at, float theta_i) const {
    return LongitudinalLobe::density_of(theta_r_, tilt_, at.lambda, shape_, theta_i);
  }

  /// F times the shape. Its integral over phi_i is E_R.
  float energy_density(float phi_i) const { return at(phi_i).energy_density; }
  /// Draws phi_i by the offset: h uniform with probability 1 - b, else |h| = 1 - x^2 with a random sign,
  /// b = (1 - E_R)^2 / 2. u in [0, 1) is used up whole. In [-pi, pi). Does not depend on the kind of Fresnel.
  float sample_azimuth(float u) const;
  /// Density of sample_azimuth(), mass 1.
  float azimuth_pdf(float phi_i) const { return at(phi_i).azimuth_pdf; }
  /// M for this phi_i: its width follows |cos(d/2)|, so phi comes first and theta_i after.
  LongitudinalLobe longitudinal(float phi_i) const;
  const SurfaceFresnel& fresnel() const { return fresnel_; }

 private:
  SurfaceFresnel fresnel_;
  float eccentricity_, theta_r_, phi_r_, tilt_, lambda_;
  float cos_phi_, sin_phi_, inverse_width_;
  float grazing_share_;  ///< b
  LongitudinalShape shape_;
};

/// E_R: the integral of energy_density() over phi_i, by quadrature (error some 1e-5). phi_r absolute, theta_r within
/// +-pi/2, radians.
float reflected_energy(ReflectionFresnel fresnel, float eta, float eccentricity, float theta_r, float phi_r);

}  // namespace tress::fiber
