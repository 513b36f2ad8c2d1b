// The closed-form parts of the paper's own model (Pekelis, Hery, Villemin, Ling 2015): N_R, N_TT, attenuation.
//
// Each has the reading that pekelis2015 renders with, and where the printed one differs and is finite, that as well:
//   eq. 2    printed cos theta_i/cos^2 theta_r under dw; corrected: integrated over dtheta_i dphi_i
//   eq. 3    printed l(theta_h), of mass 2 in theta_i; corrected: 1/2 l, normalised over the hemisphere
//   s        printed as table 3 has it, NaN for eta' < 1.188; corrected: 1 - 1/eta'
//   eq. 5    printed |cos gamma/cos theta_D|; corrected: 2 cos gamma_t/cos theta_t, the path inside
#pragma once

#include <glm/vec3.hpp>

#include "tress/adaptive/mixture.h"

namespace tress::inline v0_2::fiber {

enum class PekelisReading { corrected, as_printed };

/// N_R = cos(phi/2 sigma)/(4 sigma) for |phi| <= pi sigma, sigma <= 1; over sin(pi/2 sigma) for sigma > 1, where the
/// printed one has less than mass 1. sigma >= 0.01; phi in [-pi, pi]; 1/rad.
float pekelis_reflection(float phi, float sigma);
/// Draws from it (Hery and Ramamoorthi 2012: the arc sine). u in [0, 1].
float sample_pekelis_reflection(float u, float sigma);

/// s(theta_D) of N_TT, radians, by eta' > 1. As printed where that is a number, else corrected.
float pekelis_transmission_scale(float eta_prime, PekelisReading reading);
/// N_TT = l(phi; pi, scale) on the circle, where it is normalised.
adaptive::SkewLogistic pekelis_transmission(float scale);

/// zeta(C) of eq. 5: the absorption under which light straight through the fiber, where the rest of the exponent is
/// largest in the normal plane, has the color C. C in [0, 1]; at most that of C = 1e-30.
glm::vec3 pekelis_zeta(const glm::vec3& color, PekelisReading reading);

/// F_p T_p of one path of order 1 or 2 that enters at gamma: F by the angle in three dimensions, cos theta_d cos gamma,
/// at both ends and inside (d'Eon et al. 2011), T of eq. 5.
class PekelisAttenuation {
 public:
  PekelisAttenuation(float eta, float theta_d, const glm::vec3& zeta, PekelisReading reading);
  glm::vec3 operator()(int order, float cos_gamma) const;
  float eta_prime() const { return eta_prime_; }

 private:
  float eta_, cos_theta_d_, eta_prime_;
  float inverse_cosine_;  ///< of eq. 5's denominator, with its factor
  glm::vec3 zeta_;
};

}  // namespace tress::inline v0_2::fiber
