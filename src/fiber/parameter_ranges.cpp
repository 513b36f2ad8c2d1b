#include "tress/fiber/parameter_ranges.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "base/number_text.h"

namespace tress::inline v0_2::fiber {
namespace {

/// The first number that is out of its range.
struct Misfit {
  const char* name;  ///< of a member of FiberParameters
  ParameterRange range;
  double found;
};

class Check {
 public:
  /// Degrees that were converted to radians may be off in the last digits.
  static constexpr double rounding = 1e-5;

  void number(const char* name, float found, const ParameterRange& range) {
    const double x = found, least = range.least - rounding * std::abs(range.least),
                 most = range.most + rounding * std::abs(range.most);
    if (!misfit && !(x >= least && x <= most)) misfit = Misfit{name, range, x};
  }
  void color(const char* name, const glm::vec3& found, const ParameterRange& range) {
    for (const float channel : {found.x, found.y, found.z}) number(name, channel, range);
  }
  void angles(const char* name, const auto& found, const ParameterRange& degrees) {
    constexpr double degree = std::numbers::pi / 180;
    for (const std::optional<float> angle : found)
      if (angle) number(name, *angle, {degrees.least * degree, degrees.most * degree});
  }

  std::optional<Misfit> misfit;
};

std::optional<Misfit> misfit_of(const FiberParameters& of) {
  constexpr ParameterRange not_negative{0, std::numeric_limits<float>::max()};
  Check check;
  check.number("eta", of.eta, eta_range);
  check.number("eccentricity", of.eccentricity, eccentricity_range);
  // Beyond a circle there is no ellipse, not even by a rounding.
  if (!check.misfit && double{of.eccentricity} > eccentricity_range.most)
    check.misfit = Misfit{"eccentricity", eccentricity_range, of.eccentricity};
  const auto all_given = [](const auto& angles) {
    return std::ranges::all_of(angles, [](auto x) { return x.has_value(); });
  };
  const bool has_widths = all_given(of.azimuthal_sigma) && all_given(of.longitudinal_lambda);
  check.number("roughness", of.roughness, {has_widths ? least_roughness : roughness_range.least, roughness_range.most});
  check.number("tilt", of.tilt, not_negative);
  check.color("sigma_a", of.sigma_a, not_negative);
  check.number("medulla_radius", of.medulla_radius, medulla_radius_range);
  check.number("medulla_scattering", of.medulla_scattering, medulla_scattering_range);
  check.number("medulla_asymmetry", of.medulla_asymmetry, medulla_asymmetry_range);
  check.number("medulla_absorption", of.medulla_absorption, medulla_absorption_range);
  check.number("cortex_scattering", of.cortex_scattering, cortex_scattering_range);
  check.number("cortex_asymmetry", of.cortex_asymmetry, cortex_asymmetry_range);
  check.number("wetness", of.wetness, wetness_range);
  check.angles("azimuthal_sigma", of.azimuthal_sigma, azimuthal_sigma_range_deg);
  check.angles("longitudinal_lambda", of.longitudinal_lambda, longitudinal_lambda_range_deg);
  if (of.published_widths) {
    check.angles("published_widths", of.published_widths->azimuthal_sigma, azimuthal_sigma_range_deg);
    check.angles("published_widths", of.published_widths->longitudinal_lambda, longitudinal_lambda_range_deg);
  }
  // Its product with a density, an importance and the inverse of another gain must be a number.
  for (const glm::vec3& lobe : of.gain) check.color("gain", lobe, {0, largest_gain});
  check.number("energy_path_share", of.energy_path_share, energy_path_share_range);
  return check.misfit;
}

}  // namespace

const char* out_of_range(const FiberParameters& parameters) {
  const std::optional<Misfit> misfit = misfit_of(parameters);
  return misfit ? misfit->name : nullptr;
}

std::optional<Error> range_error(const FiberParameters& parameters) {
  const std::optional<Misfit> misfit = misfit_of(parameters);
  if (!misfit) return std::nullopt;
  return Error{"", misfit->name,
               "a number from " + number_text(misfit->range.least) + " to " + number_text(misfit->range.most),
               number_text(misfit->found)};
}

}  // namespace tress::inline v0_2::fiber
