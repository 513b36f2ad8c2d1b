// One row of the table beside its reference, for `tress-lab fit`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "tress/fiber/lobes.h"

namespace tress::inline v0_2::fiber {

/// Angles in degrees. Precondition: ranges are those of the options of `tress-lab fit` (scene/model/parameters.h).
struct RowFitRequest {
  Lobe lobe = Lobe::trt;       ///< any but the residual; trt is the whole of p = 2
  bool is_rest = false;        ///< for trt: the rest after GLINT is split off
  double eccentricity = 0.85;  ///< [0.5, 1]
  double theta_d = 30;         ///< [-89.9, 89.9]; its sign changes nothing
  double phi = 45;             ///< phi_r, absolute azimuth of the known direction from the major axis
  double sigma = 10;           ///< blur, [0.5, 45]
  double eta = 1.55;           ///< [1.05, 3]
  double sigma_a = 0;          ///< per major semi-axis, one channel
  double epsilon = 0.01;
};

/// A density on the circle, 1/rad, by absolute azimuth in radians.
using CircularDensity = std::function<double(double)>;

/// The target of a row, its fit and their parts.
struct RowFit {
  CircularDensity target, fit;
  std::vector<CircularDensity> parts;  ///< terms of the fit: components, uniform part; empty for R
  double energy = 0;                   ///< mass of the target
  std::size_t components = 0;
  std::uint64_t evaluations = 0;
  bool converged = true;
};

/// Learns the row at exactly (phi, |theta_d|). For R, which has no rows, `fit` is its closed form. Pure; any thread.
RowFit fit_row(const RowFitRequest& request);

/// The objective of the table (adaptive/options.h) against the reference, on absolute densities.
double relative_l2(const RowFit& row);

}  // namespace tress::inline v0_2::fiber
