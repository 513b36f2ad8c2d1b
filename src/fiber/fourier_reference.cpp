#include "fiber/fourier_reference.h"

#include <cmath>
#include <numbers>

#include "fiber/cross_section.h"

namespace tress::inline v0_2::fiber {

FourierReference::FourierReference(const ReferenceRequest& request) {
  const CrossSection section(request.eta, request.eccentricity, request.phi_r, request.theta_d);
  const auto terms = static_cast<std::size_t>(std::ceil(6.5 / request.sigma)) + 1;
  coefficients_.resize(terms);
  for (int i = 0; i < request.nodes; ++i) {
    const double h = (2 * i + 1.0) / request.nodes - 1;
    double share = 1;
    if (request.part != TrtPart::whole) share = section.glint_share(h, request.sigma);
    if (request.part == TrtPart::rest) share = 1 - share;
    double path_left;
    section.follow(h, request.p, 0, &path_left, [&](int order, double weight, double x, double y, double path) {
      if (order != request.p) return;
      // e^(-i m Phi) by repeated multiplication: the exit direction is e^(i Phi).
      const std::complex<double> step = std::complex<double>(x, -y) / std::hypot(x, y);
      std::complex<double> phase = share * weight * std::exp(-request.sigma_a * path) / request.nodes;
      for (std::complex<double>& c : coefficients_) {
        c += phase;
        phase = {phase.real() * step.real() - phase.imag() * step.imag(),
                 phase.real() * step.imag() + phase.imag() * step.real()};
      }
    });
  }
  for (std::size_t m = 0; m < terms; ++m) {
    const double damped = static_cast<double>(m) * request.sigma;
    coefficients_[m] *= std::exp(-0.5 * damped * damped);
  }
}

double FourierReference::density(double phi) const {
  double sum = 0.5 * coefficients_[0].real();
  for (std::size_t m = 1; m < coefficients_.size(); ++m) {
    const double angle = static_cast<double>(m) * phi;
    sum += coefficients_[m].real() * std::cos(angle) - coefficients_[m].imag() * std::sin(angle);
  }
  return sum / std::numbers::pi;
}

}  // namespace tress::inline v0_2::fiber
