#include "fiber/cross_section.h"

namespace tress::fiber {

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

}  // namespace tress::fiber
