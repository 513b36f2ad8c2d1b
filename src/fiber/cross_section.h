// Exact rays through the elliptical cross-section, which define the target (ESTIMATOR.md, E2).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "fiber/fresnel.h"

namespace tress::inline v0_2::fiber {

constexpr int traced_orders = 4;  ///< R, TT, TRT, TRRT

/// One offset h traced through orders 0..max_order. Exits are absolute azimuths (from the major axis), radians.
struct TracedOffset {
  double weight[traced_orders];   ///< A_p for clear hair; 0 if total internal reflection prevents the exit
  double azimuth[traced_orders];  ///< Phi_p in [-pi, pi]; 0 where weight is 0
  double path[traced_orders];     ///< internal 3D path length up to the exit, in major semi-axes; 0 for R
  double remaining;               ///< energy still inside after max_order
  double remaining_path;          ///< its path length so far
};

/// A known direction (phi_r absolute, theta_d) and an ellipse with major semi-axis 1 along azimuth 0. Immutable; any
/// thread.
struct CrossSection {
  CrossSection(double eta, double eccentricity, double phi_r, double theta_d);

  /// h in [-1, 1]: offset over the projected half width. max_order in [0, 3].
  void trace(double h, int max_order, TracedOffset* out) const;

  /// Follows the light after TRRT until 1e-7 of it is left, or for 300 orders. Calls visit(weight, path) for each exit,
  /// and once more with the light that is then left and its path so far, so that the weights sum to what TRRT left
  /// inside.
  template <class Visit>
  void trace_residual(double h, Visit&& visit) const;

  /// Follows all exits in order: calls visit(order, weight, x, y, path) for orders 0..max_order, except those that
  /// total internal reflection prevents. (x, y) is the exit direction in the normal plane (unit to rounding). Stops
  /// early when no more than `least` is left inside. Returns the light left inside and stores its path.
  template <class Visit>
  double follow(double h, int max_order, double least, double* path_left, Visit&& visit) const;

  /// The share of the TRT ray at h that is GLINT: c = 1/(1 + ((dPhi/dh)/(4 sigma))^2), dPhi/dh the derivative of the
  /// exit azimuth, by the chain rule. It is 1 at a caustic; it falls to 0 at the edges of the fiber and of a total
  /// internal reflection, and is 0 if that prevents the exit.
  double glint_share(double h, double sigma) const;

  double eta, eccentricity, phi_r, theta_d;
  double eta_prime, cos_theta_t;

 private:
  friend class RayBatch;
  double cos_phi_, sin_phi_;      ///< cosine and sine of phi_r
  double cos_entry_, sin_entry_;  ///< the same of the ellipse parameter where the ray with h = 0 enters
  double inverse_cos_theta_t_;
};

template <class Visit>
double CrossSection::follow(double h, int max_order, double least, double* path_left, Visit&& visit) const {
  // The ellipse is the unit circle in q = (x, y/e); its outward normal is (e qx, qy) up to length.
  const double e = eccentricity, inverse_e = 1 / e;
  const double cos_h = std::sqrt(std::max(1 - h * h, 0.0));
  double qx = cos_entry_ * cos_h - sin_entry_ * h;
  double qy = sin_entry_ * cos_h + cos_entry_ * h;
  double scale = 1 / std::sqrt(e * e * qx * qx + qy * qy);
  double nx = e * qx * scale, ny = qy * scale;

  const double cos_in = std::max(nx * cos_phi_ + ny * sin_phi_, 0.0);
  double cos_t;
  const double reflected = fresnel_entering(eta, eta_prime, cos_in, &cos_t);
  visit(0, reflected, 2 * cos_in * nx - cos_phi_, 2 * cos_in * ny - sin_phi_, 0.0);

  const double ratio = 1 / eta_prime, along = cos_in * ratio - cos_t;
  double dx = -cos_phi_ * ratio + along * nx;
  double dy = -sin_phi_ * ratio + along * ny;
  double left = 1 - reflected, path = 0;
  for (int order = 1; order <= max_order && left > least; ++order) {
    const double dqy = dy * inverse_e;
    const double chord = std::max(-2 * (qx * dx + qy * dqy) / (dx * dx + dqy * dqy), 0.0);
    path += chord * inverse_cos_theta_t_;
    qx += chord * dx;
    qy += chord * dqy;
    const double onto_circle = 1.5 - 0.5 * (qx * qx + qy * qy);  // one Newton step, so that drift cannot build up
    qx *= onto_circle;
    qy *= onto_circle;
    scale = 1 / std::sqrt(e * e * qx * qx + qy * qy);
    nx = e * qx * scale;
    ny = qy * scale;
    const double cos_inside = dx * nx + dy * ny;
    const double kept = fresnel_leaving(eta, eta_prime, cos_inside, &cos_t);
    if (kept < 1) {
      const double normal = cos_t - eta_prime * cos_inside;
      visit(order, left * (1 - kept), eta_prime * dx + normal * nx, eta_prime * dy + normal * ny, path);
    }
    left *= kept;
    dx -= 2 * cos_inside * nx;
    dy -= 2 * cos_inside * ny;
    const double onto_unit = 1.5 - 0.5 * (dx * dx + dy * dy);
    dx *= onto_unit;
    dy *= onto_unit;
  }
  *path_left = path;
  return left;
}

template <class Visit>
void CrossSection::trace_residual(double h, Visit&& visit) const {
  constexpr int last_order = 300;
  constexpr double least = 1e-7;
  double path;
  const double left = follow(h, last_order, least, &path, [&](int order, double weight, double, double, double length) {
    if (order >= traced_orders) visit(weight, length);
  });
  visit(left, path);
}

}  // namespace tress::inline v0_2::fiber
