// tress fit: one row of the table beside its reference.
#pragma once

#include <filesystem>
#include <optional>

#include "tress/fiber/lobes.h"

namespace tress::cli {

/// Angles in degrees, as typed. Every value in range.
struct FitSettings {
  fiber::Lobe lobe = fiber::Lobe::trt;  ///< any but the residual; trt is the whole of p = 2
  double eccentricity = 0.85;           ///< [0.5, 1]
  double theta_d = 30;                  ///< [-89.9, 89.9]; its sign changes nothing
  double phi = 45;                      ///< phi_r, absolute azimuth of the known direction from the major axis
  double sigma = 10;                    ///< blur, [.5, 45]
  double eta = 1.55;                    ///< [1.05, 3]
  double sigma_a = 0;                   ///< per major semi-axis, one channel
  double epsilon = 0.01;
  int samples = 360;  ///< azimuths printed
  bool json = false;
  std::optional<std::filesystem::path> plot;  ///< PNG
};

/// Learns the row at exactly (phi, theta_d) and prints or draws it beside the Fourier reference.
/// Exit status 1 if the row does not converge.
int run_fit(const FitSettings& settings);

}  // namespace tress::cli
