// Traces sixteen rays through a cross-section at once in vector lanes, which hides the latency of each step.
#pragma once

#include "fiber/cross_section.h"

namespace tress::inline v0_2::fiber {

/// Steps 16 rays from order to order, in plain loops over lanes that compilers vectorise. The arithmetic is that of
/// CrossSection::follow without branches: at total internal reflection, cos_t = 0 gives reflectance 1. One thread per
/// object.
class RayBatch {
 public:
  static constexpr int lanes = 16;

  /// Rays at offsets h_0 + i h_step, refracted into the fiber; weight() is then that of order 0 (R). with_rates: also
  /// follows the derivatives of their angles by h, which glint_shares() needs.
  RayBatch(const CrossSection& section, double h_0, double h_step, bool with_rates = false);

  /// Moves to the next order, to which weight, exit direction and path then belong. The weight is 0 under total
  /// internal reflection.
  void advance();

  const double* weight() const { return weight_; }  ///< A_p of clear hair
  const double* path() const { return path_; }      ///< internal 3D path, major semi-axes
  const double* left() const { return left_; }      ///< energy still inside
  /// Exit azimuths relative to phi_r in [-pi, pi], radians, to 1e-7. Orders >= 1; arbitrary where weight is 0.
  void azimuths(float* out) const;
  /// CrossSection::glint_share of every ray at the current order. Needs with_rates.
  void glint_shares(double sigma, double* out) const;

 private:
  template <bool with_rates>
  void step();
  void step_without_rates();
  void step_with_rates();

  const CrossSection& section_;
  double qx_[lanes], qy_[lanes], dx_[lanes], dy_[lanes];
  double exit_x_[lanes], exit_y_[lanes];
  double weight_[lanes], path_[lanes], left_[lanes];
  bool with_rates_;
  double rate_t_[lanes], rate_delta_[lanes];  ///< derivatives by h of the ellipse parameter and of the direction inside
  double cos_exit_[lanes], spread_[lanes];    ///< cosine of the exit, and dPhi/dh times it
};

}  // namespace tress::inline v0_2::fiber
