#include "tress/fiber/parameter_ranges.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace tress::inline v0_2::fiber {
namespace {

/// False for NaN.
bool is_within(float x, const ParameterRange& range) {
  constexpr double rounding = 1e-5;
  return double{x} >= range.least - rounding * std::abs(range.least) &&
         double{x} <= range.most + rounding * std::abs(range.most);
}

bool is_not_negative(const glm::vec3& color) {
  const auto sound = [](float x) { return std::isfinite(x) && x >= 0; };
  return sound(color.x) && sound(color.y) && sound(color.z);
}

bool are_angles(const auto& angles, const ParameterRange& degrees) {
  constexpr double degree = std::numbers::pi / 180;
  return std::ranges::all_of(angles, [&](const std::optional<float> angle) {
    return !angle || is_within(*angle, {degrees.least * degree, degrees.most * degree});
  });
}

}  // namespace

const char* out_of_range(const FiberParameters& parameters) {
  if (!is_within(parameters.eta, eta_range)) return "eta";
  if (!is_within(parameters.eccentricity, eccentricity_range) ||
      double{parameters.eccentricity} > eccentricity_range.most)
    return "eccentricity";
  if (!is_within(parameters.roughness, roughness_range)) return "roughness";
  if (!(std::isfinite(parameters.tilt) && parameters.tilt >= 0)) return "tilt";
  if (!is_not_negative(parameters.sigma_a)) return "sigma_a";
  if (!is_within(parameters.medulla_radius, medulla_radius_range)) return "medulla_radius";
  if (!is_within(parameters.medulla_scattering, medulla_scattering_range)) return "medulla_scattering";
  if (!is_within(parameters.medulla_asymmetry, medulla_asymmetry_range)) return "medulla_asymmetry";
  if (!is_within(parameters.medulla_absorption, medulla_absorption_range)) return "medulla_absorption";
  if (!are_angles(parameters.azimuthal_sigma, azimuthal_sigma_range_deg)) return "azimuthal_sigma";
  if (!are_angles(parameters.longitudinal_lambda, longitudinal_lambda_range_deg)) return "longitudinal_lambda";
  if (const auto& published = parameters.published_widths;
      published && !(are_angles(published->azimuthal_sigma, azimuthal_sigma_range_deg) &&
                     are_angles(published->longitudinal_lambda, longitudinal_lambda_range_deg)))
    return "published_widths";
  if (!std::ranges::all_of(parameters.gain, is_not_negative)) return "gain";
  if (!is_within(parameters.energy_path_share, energy_path_share_range)) return "energy_path_share";
  return nullptr;
}

}  // namespace tress::inline v0_2::fiber
