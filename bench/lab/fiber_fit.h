// The traced rough elliptical fiber whose scattered light is nearest to a goniophotometer's.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "scene/model/parameters.h"

namespace tress::lab {

/// A number of the fiber that is fitted or held.
struct FiberNumber {
  std::string_view name;
  scene::Range range;
  std::array<double, 2> starts;  ///< the fit begins at the best candidate among these
  double offset;                 ///< steps are taken in the logarithm of the number plus this, which is above 0
};
/// Tilt in degrees, sigma_a and scattering per major semi-axis, the radius a share of the semi-axes.
inline constexpr std::array<FiberNumber, 6> fiber_numbers{{{"eccentricity", {0.5, 1}, {0.72, 0.93}, 0},
                                                           {"roughness", {0.01, 1}, {0.08, 0.25}, 0},
                                                           {"tilt", {0, 15}, {3, 3}, 3},
                                                           {"sigma_a", {0, 50}, {0.1, 0.8}, 0.1},
                                                           {"medulla_radius", {0, 0.95}, {0.5, 0.5}, 0.3},
                                                           {"medulla_scattering", {0, 100}, {1, 8}, 0.3}}};
inline constexpr std::size_t first_of_medulla = 4;
using FiberValues = std::array<double, fiber_numbers.size()>;

/// Light that leaves towards an inclination theta and an azimuth phi, which is 0 on the side of the source. Radians.
/// value: power per solid angle of any scale, finite.
struct GonioSample {
  double phi, theta, value;
};

/// Angles in radians.
struct FiberFitRequest {
  std::vector<GonioSample> samples;  ///< one value at least is above 0
  double incidence = 0;              ///< inclination of the direction to the source, towards the tip
  std::optional<double> rotation;    ///< azimuth of the source from the major axis; empty: all alike
  double detector = 0;               ///< angle that the detector is wide, > 0
  double eta = 1.55;
  std::array<std::optional<double>, fiber_numbers.size()> held{};
  std::uint64_t paths = 1 << 18;  ///< of each candidate
  std::uint64_t seed = 0;
};

struct FiberFit {
  FiberValues values{}, errors{};  ///< standard errors; 0: it is held; infinite: the light does not depend on it
  double scale = 0;                ///< the measured values over the traced light per steradian
  std::vector<double> light;       ///< the traced light times `scale`, of each sample
  double residual = 0;             ///< L2 of the differences over that of the values, both weighted
  double noise = 0;                ///< the same of traced light with another seed, beside its mean
  int candidates = 0;              ///< traced
};

/// Fits by weighted least squares: a sample weighs 1 over its value plus 0.05 of the mean value, as if its variance
/// were in proportion to its light. The light of a candidate is that of split paths through a window as wide as the
/// detector, with the same random numbers for all candidates, so that their differences have little noise. Errors are
/// what the noise of the traced light moves the fit by (16 other seeds), larger in proportion where the residual is
/// above that noise. Same request, same bits, for any number of threads (oneTBB).
FiberFit fit_fiber(const FiberFitRequest& request);

}  // namespace tress::lab
