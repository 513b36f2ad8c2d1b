// The R lobe in closed form for every eccentricity, sampled by the offset h.
#pragma once

#include <algorithm>
#include <cmath>

#include "base/arctangent.h"
#include "base/float4.h"
#include "base/quarter_sine.h"
#include "fiber/longitudinal.h"
#include "fiber/row_axes.h"
#include "fiber/surface_fresnel.h"
#include "tress/adaptive/mixture.h"

namespace tress::inline v0_2::fiber {

/// Light reflected at the surface, for one known direction. Let d = wrap(phi_i - phi_r), and let nu = phi_r + d/2 be
/// the normal's azimuth. The azimuthal density is F(|cos(d/2)|; theta_r) times the shape
///  1/2 |dh/dphi_i| = 1/4 e^2 cos(d/2) / (w(phi_r) s^3),  s^2 = cos^2 nu + e^2 sin^2 nu.
/// Fresnel and energy are both at |theta_d| = |theta_r|, so E_R N^_R is energy_density() without any division. Azimuths
/// are absolute (from the major axis), in radians; densities are in 1/rad. There is no blur in azimuth. Immutable plain
/// data; any thread.
class ReflectionLobe {
 public:
  /// energy: E_R at (phi_r, theta_r), which determines the mix of sampling; any value in [0, 1] gives a valid sampler.
  /// tilt, lambda: of the longitudinal lobe in theta_h; lambda is without the factor |cos(d/2)|.
  ReflectionLobe(float eta, float eccentricity, float theta_r, float phi_r, float energy, float tilt, float lambda,
                 ReflectionFresnel fresnel = ReflectionFresnel::exact,
                 LongitudinalShape longitudinal_shape = LongitudinalShape::logistic)
      : fresnel_(eta, std::clamp(theta_r, -half_pi, half_pi), fresnel),
        eccentricity_(eccentricity),
        theta_r_(theta_r),
        phi_r_(adaptive::wrap_angle(phi_r)),
        tilt_(tilt),
        lambda_(lambda),
        shape_(longitudinal_shape) {
    const FoldedAzimuth folded = fold_azimuth(phi_r_);
    const Float4 sines = quarter_sine(Float4{folded.phi, from_quarter(folded.phi), 0, 0});
    sin_phi_ = phi_r_ < 0 ? -sines[0] : sines[0];
    cos_phi_ = (phi_r_ < 0) == (folded.sign < 0) ? sines[1] : -sines[1];
    const float across = eccentricity * cos_phi_;
    inverse_width_ = 1 / std::sqrt(sin_phi_ * sin_phi_ + across * across);
    const float lost = 1 - std::clamp(energy, 0.0f, 1.0f);
    grazing_share_ = 0.5f * lost * lost;
  }

  /// All values at one phi_i, from one pass over its geometry.
  struct At {
    float energy_density, azimuth_pdf;
    float lambda;  ///< lambda of M here
  };
  At at(float phi_i) const { return at_difference(adaptive::wrap_angle(phi_i - phi_r_)); }
  /// The same for d = wrap(phi_i - phi_r).
  At at_difference(float d) const {
    // The ellipse parameter of the point with normal nu has cosine cos nu / s and sine e sin nu / s; that of the ray
    // with h = 0 has e cos phi_r / w and sin phi_r / w. h is the sine of their difference, and dt/dnu = e / s^2.
    const float half = 0.5f * d;
    const Float4 sines = quarter_sine(Float4{half, from_quarter(half), 0, 0});
    const float sin_half = sines[0], cos_half = sines[1];
    const float cos_nu = cos_phi_ * cos_half - sin_phi_ * sin_half;
    const float sin_nu = eccentricity_ * (sin_phi_ * cos_half + cos_phi_ * sin_half);
    const float inverse_s2 = 1 / (cos_nu * cos_nu + sin_nu * sin_nu);
    const float inverse_both = inverse_width_ * std::sqrt(inverse_s2);
    const float rate = 0.25f * eccentricity_ * inverse_s2;  // the density over sqrt(1 - h^2), which does not vanish
    const float density = eccentricity_ * cos_half * inverse_both * rate;
    const float offset = (eccentricity_ * sin_nu * cos_phi_ - cos_nu * sin_phi_) * inverse_both;
    // The pdf of |h| = 1 - x^2 diverges at |h| = 1 as 1/sqrt(1 - |h|); times the shape's sqrt(1 - h^2) it is finite.
    const float grazing = 0.5f * rate * std::sqrt(1 + std::min(std::abs(offset), 1.0f));
    return {density * fresnel_(cos_half), (1 - grazing_share_) * density + grazing_share_ * grazing,
            lambda_ * cos_half};
  }
  /// M there, 1/rad: longitudinal(phi_i).density(theta_i).
  float longitudinal_density(const At& at, float theta_i) const {
    return LongitudinalLobe::density_of(theta_r_, tilt_, at.lambda, shape_, theta_i);
  }

  /// F times the shape. Its integral over phi_i is E_R.
  float energy_density(float phi_i) const { return at(phi_i).energy_density; }
  /// Draws phi_i by the offset: h uniform with probability 1 - b, else |h| = 1 - x^2 with a random sign, b = (1 -
  /// E_R)^2 / 2. u in [0, 1); all its bits are used. The result is in [-pi, pi). It does not depend on the kind of
  /// Fresnel.
  float sample_azimuth(float u) const {
    const float b = grazing_share_;
    float h, cos_h;  // h and the cosine, of the angle between the point's ellipse parameter and that of h = 0
    if (u < 1 - b) {
      const float share = u / (1 - b);
      h = 2 * share - 1;
      cos_h = 2 * std::sqrt(std::max(share * (1 - share), 0.0f));
    } else {
      float v = std::min((u - (1 - b)) / b, 1.0f) * 2;
      const float sign = v < 1 ? -1.0f : 1.0f;
      if (v >= 1) v -= 1;
      const float deficit = v * v;  // 1 - |h|
      h = sign * (1 - deficit);
      cos_h = v * std::sqrt(2 - deficit);
    }
    const float cos_0 = eccentricity_ * cos_phi_ * inverse_width_, sin_0 = sin_phi_ * inverse_width_;
    const float x = cos_0 * cos_h - sin_0 * h, y = sin_0 * cos_h + cos_0 * h;
    return wrap_once(2 * angle_of(y, eccentricity_ * x) - phi_r_);
  }
  /// The density of sample_azimuth(), of mass 1.
  float azimuth_pdf(float phi_i) const { return at(phi_i).azimuth_pdf; }
  /// M for this phi_i: its width depends on |cos(d/2)|, so phi is drawn first and theta_i after.
  LongitudinalLobe longitudinal(float phi_i) const {
    const float half = 0.5f * adaptive::wrap_angle(phi_i - phi_r_);
    return LongitudinalLobe(theta_r_, tilt_, lambda_ * quarter_cosine(half), shape_);
  }
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

}  // namespace tress::inline v0_2::fiber
