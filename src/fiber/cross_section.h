// Rays through the elliptical cross-section: the target, traced exactly (design section 3, ESTIMATOR.md E2).
#pragma once

#include <cstdint>

namespace tress::fiber {

constexpr int traced_orders = 4;  ///< R, TT, TRT, TRRT

/// One offset h traced through orders 0..max_order. Exits are absolute azimuths (from the major axis), radians.
struct TracedOffset {
  double weight[traced_orders];   ///< A_p for clear hair; 0 where total internal reflection bars the exit
  double azimuth[traced_orders];  ///< Phi_p; undefined where weight is 0
  double path[traced_orders];     ///< internal 3D path length up to the exit, in major semi-axes; 0 for R
  double remaining;               ///< energy still inside after max_order
  double remaining_path;          ///< its path so far
};

/// Known direction (phi_r absolute, theta_d), ellipse of major semi-axis 1 along azimuth 0.
struct CrossSection {
  CrossSection(double eta, double eccentricity, double phi_r, double theta_d);

  /// h in [-1, 1]: offset over the projected half width. max_order in [0, 3].
  void trace(double h, int max_order, TracedOffset* out) const;

  /// Follows the light after TRRT until `energy` of it is left or 300 orders: calls visit(weight, path) per exit.
  template <class Visit>
  void trace_residual(double h, Visit&& visit) const;

  double eta, eccentricity, phi_r, theta_d;
  double eta_prime, cos_theta_t;
};

}  // namespace tress::fiber
