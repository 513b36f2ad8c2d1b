// Exact dielectric Fresnel reflectance in the projected plane of a fiber (Bravais).
#pragma once

#include <algorithm>
#include <cmath>

namespace tress::inline v0_2::fiber {

/// Returns eta' = sqrt(eta^2 - sin^2 theta) / max(cos theta, 1e-6).
inline double bravais_index(double eta, double theta) {
  const double s = std::sin(theta);
  return std::sqrt(eta * eta - s * s) / std::max(std::cos(theta), 1e-6);
}

/// Unpolarised reflectance from the projected cosines on the air side and inside; the same for light from either side.
inline double fresnel_reflectance(double eta, double eta_prime, double cos_air, double cos_inside) {
  const double inside = eta_prime * cos_inside;
  const double rs = (cos_air - inside) / (cos_air + inside);
  const double scaled = eta * eta * cos_air;
  const double rp = (scaled - inside) / (scaled + inside);
  return 0.5 * (rs * rs + rp * rp);
}

/// Unpolarised reflectance for a projected ray in air. cos_gamma: cosine of its angle to the projected normal;
/// *cos_gamma_t receives the projected refracted cosine (always from eta').
inline double fresnel_entering(double eta, double eta_prime, double cos_gamma, double* cos_gamma_t) {
  const double sin2 = std::max(1 - cos_gamma * cos_gamma, 0.0) / (eta_prime * eta_prime);
  *cos_gamma_t = std::sqrt(1 - sin2);
  return fresnel_reflectance(eta, eta_prime, cos_gamma, *cos_gamma_t);
}

/// The same from inside. Under total internal reflection it is 1 and *cos_gamma_t is 0.
inline double fresnel_leaving(double eta, double eta_prime, double cos_gamma_inside, double* cos_gamma_t) {
  const double sin2 = std::max(1 - cos_gamma_inside * cos_gamma_inside, 0.0) * eta_prime * eta_prime;
  if (sin2 >= 1) {
    *cos_gamma_t = 0;
    return 1;
  }
  *cos_gamma_t = std::sqrt(1 - sin2);
  return fresnel_reflectance(eta, eta_prime, *cos_gamma_t, cos_gamma_inside);
}

}  // namespace tress::inline v0_2::fiber
