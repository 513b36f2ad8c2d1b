#include "fiber/cross_section.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tress::inline v0_2::fiber {

CrossSection::CrossSection(double eta_, double eccentricity_, double phi_r_, double theta_d_)
    : eta(eta_), eccentricity(eccentricity_), phi_r(phi_r_), theta_d(theta_d_) {
  const double sin_theta_t = std::sin(theta_d) / eta;
  eta_prime = bravais_index(eta, theta_d);
  cos_theta_t = std::sqrt(1 - sin_theta_t * sin_theta_t);
  inverse_cos_theta_t_ = 1 / cos_theta_t;
  cos_phi_ = std::cos(phi_r);
  sin_phi_ = std::sin(phi_r);
  const double across = eccentricity * cos_phi_;
  const double inverse_width = 1 / std::sqrt(sin_phi_ * sin_phi_ + across * across);
  cos_entry_ = across * inverse_width;
  sin_entry_ = sin_phi_ * inverse_width;
}

void CrossSection::trace(double h, int max_order, TracedOffset* out) const {
  *out = TracedOffset{};
  out->remaining =
      follow(h, max_order, 0, &out->remaining_path, [out](int order, double weight, double x, double y, double path) {
        out->weight[order] = weight;
        out->azimuth[order] = std::atan2(y, x);
        out->path[order] = path;
      });
}

double CrossSection::glint_share(double h, double sigma) const {
  // Angles in the normal plane: t is the ellipse parameter, nu = atan2(sin t, e cos t) the normal, delta the direction
  // inside. Entering keeps sin(gamma_t) = sin(gamma_i)/eta', gamma_i = phi_r - nu, delta = nu + pi + gamma_t. A chord
  // takes t to 2 delta' - t, tan delta' = tan(delta)/e. Reflection takes delta to 2 nu + pi - delta. Leaving keeps
  // sin(gamma_out) = eta' sin(gamma_in), Phi = nu + gamma_out.
  const double e = eccentricity, cos_h = std::sqrt(std::max(1 - h * h, 1e-24));
  double t = std::atan2(sin_entry_, cos_entry_) + std::asin(h), rate_t = 1 / cos_h;
  double nu = std::atan2(std::sin(t), e * std::cos(t));
  const auto normal_rate = [&] { return e / (e * e * std::cos(t) * std::cos(t) + std::sin(t) * std::sin(t)); };
  const double sin_in = std::sin(phi_r - nu), cos_in = std::sqrt(std::max(1 - sin_in * sin_in, 0.0));
  const double sin_t = sin_in / eta_prime, cos_t = std::sqrt(1 - sin_t * sin_t);
  double delta = nu + std::numbers::pi + std::asin(sin_t);
  double rate_delta = normal_rate() * rate_t * (1 - cos_in / (eta_prime * cos_t));
  for (int chord = 0; chord < 2; ++chord) {
    if (chord == 1) {
      delta = 2 * nu + std::numbers::pi - delta;
      rate_delta = 2 * normal_rate() * rate_t - rate_delta;
    }
    const double x = std::cos(delta), y = std::sin(delta) / e;
    t = 2 * std::atan2(y, x) - t - std::numbers::pi;
    rate_t = 2 * rate_delta / (e * (x * x + y * y)) - rate_t;
    nu = std::atan2(std::sin(t), e * std::cos(t));
  }
  const double sin_out = eta_prime * std::sin(delta - nu), cos2_out = 1 - sin_out * sin_out;
  if (!(cos2_out > 0)) return 0;
  const double cos_out = std::sqrt(cos2_out), rate_nu = normal_rate() * rate_t;
  const double rate = rate_nu + eta_prime * std::abs(std::cos(delta - nu)) / cos_out * (rate_delta - rate_nu);
  const double steepness = rate / (4 * sigma);
  return 1 / (1 + steepness * steepness);
}

}  // namespace tress::inline v0_2::fiber
