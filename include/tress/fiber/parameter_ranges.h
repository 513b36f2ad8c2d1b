// The ranges of FiberParameters, defined here only.
#pragma once

#include <optional>

#include "tress/base/error.h"
#include "tress/fiber/parameters.h"

namespace tress::inline v0_2::fiber {

/// A range that includes both ends.
struct ParameterRange {
  double least, most;
};
inline constexpr ParameterRange eta_range{1.05, 3};
inline constexpr ParameterRange eccentricity_range{0.5, 1};
inline constexpr ParameterRange roughness_range{0.01, 1};
/// A fiber whose lobes have widths of their own may be smoother, down to this: its energies are those of a smooth one.
inline constexpr double least_roughness = 0.001;
inline constexpr ParameterRange azimuthal_sigma_range_deg{0.5, 45};
inline constexpr ParameterRange longitudinal_lambda_range_deg{0.25, 45};
inline constexpr ParameterRange energy_path_share_range{0.01, 1};
/// The sensible ranges for hair; every finite number >= 0 is valid, of gains up to largest_gain.
inline constexpr ParameterRange tilt_range_deg{0, 15};
inline constexpr ParameterRange sigma_a_range{0, 1e4};
inline constexpr ParameterRange medulla_radius_range{0, 0.95};
inline constexpr ParameterRange medulla_scattering_range{0, 100};
inline constexpr ParameterRange medulla_asymmetry_range{-0.95, 0.95};
inline constexpr ParameterRange medulla_absorption_range{0, 100};
inline constexpr ParameterRange cortex_scattering_range{0, 20};
inline constexpr ParameterRange cortex_asymmetry_range = medulla_asymmetry_range;
inline constexpr ParameterRange wetness_range{0, 1};
inline constexpr ParameterRange gain_range{0, 100};
inline constexpr double largest_gain = 1e15;

/// Null if the parameters are valid for every model, else the name of a member of FiberParameters that is out of its
/// range or not finite. Ends of ranges have a relative tolerance of 1e-5, for degrees that were converted to radians.
/// Any thread.
const char* out_of_range(const FiberParameters& parameters);
/// The same with the range and what was found; angles in radians. Its place is the member's name.
std::optional<Error> range_error(const FiberParameters& parameters);

}  // namespace tress::inline v0_2::fiber
