// Learns one row of the table on its own until it converges.
#pragma once

#include <cstddef>
#include <cstdint>

#include "tress/adaptive/mixture.h"

namespace tress::inline v0_2::fiber {

/// Angles in radians.
struct RowRequest {
  int slice_lobe = 1;  ///< the same as in elliptical_slice()
  float eta = 1.55f, eccentricity = 0.85f, sigma = 0.2f;
  float phi_r = 0;    ///< any turn
  float theta_d = 0;  ///< sign ignored
  double epsilon = 0.01;
};

struct LearnedRow {
  bool converged = false;
  adaptive::Mixture fit;  ///< clear, over the relative azimuth of the folded phi_r; with attributes if converged
  std::uint64_t evaluations = 0;
  float phi_r = 0, sign = 1;

  /// The density of the row at an absolute azimuth under an absorption, 1/rad: each component is weighted by the gamma
  /// law of its path lengths. sigma_a >= 0 per major semi-axis.
  double density(double phi, double sigma_a) const;
  /// The density of one component, or of the uniform part if `part` = fit.component_count. They add up to density().
  double density_of(std::size_t part, double phi, double sigma_a) const;
};

/// Learns the row at exactly (phi_r, |theta_d|) from samples of its own proposal, as a render would: a slice of one
/// node is scored and observed pass by pass until it has converged or is refused.
LearnedRow learn_row(const RowRequest& request);

/// The share of a component's light that an absorption leaves, for path lengths of this mean and variance: (1 + sigma_a
/// v/l)^(-l^2/v), exp(-sigma_a l) for v -> 0. It is in (0, 1].
double transmitted_share(double sigma_a, double mean, double variance);

}  // namespace tress::inline v0_2::fiber
