// One row of the table, learned on its own to convergence.
#pragma once

#include <cstddef>
#include <cstdint>

#include "tress/adaptive/mixture.h"

namespace tress::fiber {

/// Angles in radians.
struct RowRequest {
  int slice_lobe = 1;  ///< as of elliptical_slice()
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

  /// The row at an absolute azimuth under an absorption, 1/rad: each component weighed by the gamma law of its path
  /// lengths. sigma_a >= 0 per major semi-axis.
  double density(double phi, double sigma_a) const;
  /// Of one component, or of the uniform part: `part` = fit.component_count. They add up to density().
  double density_of(std::size_t part, double phi, double sigma_a) const;
};

/// Learns the row at exactly (phi_r, |theta_d|), from samples of its own proposal, as a render would: a slice of one
/// node, scored and observed pass by pass until the service calls it converged, or refuses it.
LearnedRow learn_row(const RowRequest& request);

/// Share of the light of a component that an absorption leaves, path lengths of this mean and variance:
/// (1 + sigma_a v/l)^(-l^2/v), exp(-sigma_a l) for v -> 0. In (0, 1].
double transmitted_share(double sigma_a, double mean, double variance);

}  // namespace tress::fiber
