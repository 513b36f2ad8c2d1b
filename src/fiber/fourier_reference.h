// The reference for a lobe's azimuthal density: the Fourier series of the traced exits.
#pragma once

#include <complex>
#include <vector>

namespace tress::inline v0_2::fiber {

/// The part of the rays of TRT.
enum class TrtPart { whole, glint, rest };

/// The density to evaluate. Radians; sigma_a per major semi-axis.
struct ReferenceRequest {
  double eta = 1.55;
  double eccentricity = 0.85;
  double theta_d = 0;
  double phi_r = 0;    ///< known direction, absolute
  double sigma = 0.2;  ///< blur of the exit azimuth, > 0
  double sigma_a = 0;
  int p = 1;                      ///< 0 (R, traced and blurred), 1, 2, 3
  TrtPart part = TrtPart::whole;  ///< used if p = 2
  int nodes = 2048;               ///< number of midpoints in h
};

/// N_p(phi) = 1/2 integral A_p(h) e^(-sigma_a l(h)) G_sigma(phi - Phi_p(h)) dh, as c_m = 1/2 integral A e^(-i m Phi) dh
/// times e^(-m^2 sigma^2 / 2), m up to ceil(6.5 / sigma). It shares only the tracer with rows and mixtures. Immutable;
/// any thread.
class FourierReference {
 public:
  explicit FourierReference(const ReferenceRequest& request);

  /// 1/rad at an absolute azimuth; rounding may make it slightly negative (1e-9).
  double density(double phi) const;
  /// The mass E_p.
  double energy() const { return coefficients_[0].real(); }

 private:
  std::vector<std::complex<double>> coefficients_;  ///< m = 0, 1, ...; those of -m are conjugate
};

}  // namespace tress::inline v0_2::fiber
