// What the fit command works with: one row of the table, learned on its own to convergence, and curves over the azimuth
// as a small picture.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "image/picture.h"
#include "tress/adaptive/mixture.h"
#include "tress/fiber/lobes.h"

namespace tress::cli {

/// Angles in radians.
struct RowRequest {
  int slice_lobe = 1;  ///< as of fiber::elliptical_slice()
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
  /// lengths (design section 3, color). sigma_a >= 0 per major semi-axis.
  double density(double phi, double sigma_a) const;
};

/// Learns the row at exactly (phi_r, |theta_d|), from samples of its own proposal, as a render would: a slice of one
/// node, scored and observed pass by pass until the service calls it converged, or refuses it.
LearnedRow learn_row(const RowRequest& request);

/// Share of the light of a component that an absorption leaves, path lengths of this mean and variance:
/// (1 + sigma_a v/l)^(-l^2/v), exp(-sigma_a l) for v -> 0. In (0, 1].
double transmitted_share(double sigma_a, double mean, double variance);

/// A line of one color, linear RGB. Values over equally spaced azimuths from -180 degrees, finite, >= 0.
struct Curve {
  std::string name;  ///< in the legend, ASCII
  std::vector<double> values;
  glm::vec3 color;
};

/// 1200 x 720, white: axes with numbers, a legend, the lines of the title (ASCII) above; the vertical axis begins at 0.
image::Picture plot_curves(const std::vector<Curve>& curves, const std::vector<std::string>& title);

}  // namespace tress::cli
