// Exact dielectric Fresnel reflectance in the projected plane of a fiber (Bravais).
#pragma once

namespace tress::fiber {

/// eta' = sqrt(eta^2 - sin^2 theta) / max(cos theta, 1e-6).
double bravais_index(double eta, double theta);

/// Mean of the two polarisations for a projected ray in air with cosine `cos_gamma` of the angle to the projected
/// normal, inclination theta; *cos_gamma_t receives the projected refracted cosine (always from eta').
double fresnel_entering(double eta, double eta_prime, double cos_gamma, double* cos_gamma_t);
/// The same from inside; 1 and *cos_gamma_t = 0 under total internal reflection.
double fresnel_leaving(double eta, double eta_prime, double cos_gamma_inside, double* cos_gamma_t);

}  // namespace tress::fiber
