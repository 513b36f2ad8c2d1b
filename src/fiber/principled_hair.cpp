#include "tress/fiber/principled_hair.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/common.hpp>
#include <numbers>

#include "base/pi.h"
#include "tress/fiber/parameter_ranges.h"

namespace tress::inline v0_2::fiber {
namespace {

/// Roughness of a surface whose energies are those of a smooth one, but for oblique light in hair that absorbs little.
constexpr float all_but_smooth = 0.02f;

float within(const ParameterRange& range, double x) {
  return static_cast<float>(std::clamp(x, range.least, range.most));
}

float angle_within(const ParameterRange& degrees, double radians) {
  return static_cast<float>(std::clamp(radians, degrees.least * degree, degrees.most * degree));
}

/// Standard deviation of theta_i of a lobe of roughness beta_M (Chiang et al. 2016, equation 7).
double deviation_of(double beta) {
  const double b = std::clamp(beta, 0.001, 1.0);
  return 0.726 * b + 0.812 * b * b + 3.7 * std::pow(b, 20);
}

/// Logistic scale of the exit azimuth (equation 8).
double logistic_scale_of(double beta) {
  const double b = std::clamp(beta, 0.001, 1.0);
  return (0.265 * b + 1.194 * b * b + 5.372 * std::pow(b, 22)) * std::sqrt(std::numbers::pi / 8);
}

/// lambda of a Gaussian lobe over the standard deviation of theta_i, by lobe. Fitted to pictures of Chiang's model
/// itself, a lock and thin hair in five looks, by `bench/principled/mapping.py fit` (scenes/blender/README.md).
constexpr std::array<double, 4> lambda_per_deviation{0.429, 0.405, 0.416, 0.416};
/// Those of equal half widths; |cos(d/2)| narrows R by pi/4 in the mean.
constexpr std::array<double, 4> equal_lambda_per_deviation{0.425, 0.334, 0.334, 0.334};
/// The blur of the exit azimuth over the standard deviation of the logistic law, fitted likewise: TT, TRT, TRRT.
constexpr std::array<double, 3> azimuth_per_deviation{1.08, 2.53, 2.53};
constexpr double logistic_deviation = std::numbers::pi / std::numbers::sqrt3;  ///< of a logistic of scale 1
/// lambda, which is in theta_h, of a lobe over its standard deviation of theta_i; `chiang2016` inverts it.
constexpr double published_lambda_per_deviation = 0.5 / logistic_deviation;

/// deviations: standard deviations of theta_i of R, TT, TRT; scales: logistic scales of the exit azimuth of TT, TRT.
/// Lobes after TRT are as TRT.
FiberParameters round_fiber(const std::array<double, 3>& deviations, const std::array<double, 2>& scales,
                            PrincipledWidths widths) {
  const bool equal = widths == PrincipledWidths::equal;
  FiberParameters fiber;
  fiber.eccentricity = 1;
  fiber.roughness = equal ? static_cast<float>(least_roughness) : all_but_smooth;
  LobeWidthsGiven published{};
  for (std::size_t p = 0; p < published.longitudinal_lambda.size(); ++p) {
    const double deviation = deviations[std::min<std::size_t>(p, 2)];
    const double lambda = (equal ? equal_lambda_per_deviation : lambda_per_deviation)[p] * deviation;
    fiber.longitudinal_lambda[p] = angle_within(longitudinal_lambda_range_deg, lambda);
    published.longitudinal_lambda[p] =
        angle_within(longitudinal_lambda_range_deg, published_lambda_per_deviation * deviation);
  }
  for (std::size_t p = 0; p < published.azimuthal_sigma.size(); ++p) {
    const double deviation = scales[std::min<std::size_t>(p, 1)] * logistic_deviation;
    fiber.azimuthal_sigma[p] =
        angle_within(azimuthal_sigma_range_deg, (equal ? 1 : azimuth_per_deviation[p]) * deviation);
    published.azimuthal_sigma[p] = angle_within(azimuthal_sigma_range_deg, deviation);
  }
  if (widths == PrincipledWidths::published) {
    std::ranges::copy(published.longitudinal_lambda, fiber.longitudinal_lambda.begin());
    std::ranges::copy(published.azimuthal_sigma, fiber.azimuthal_sigma.begin());
  }
  if (widths == PrincipledWidths::by_model || widths == PrincipledWidths::published) fiber.published_widths = published;
  fiber.longitudinal_shape = LongitudinalShape::gaussian;
  return fiber;
}

FiberParameters round_fiber(const PrincipledHair& hair) {
  const double all = deviation_of(hair.roughness);
  const double coated = deviation_of(hair.roughness * (1 - std::clamp(hair.coat, 0.0f, 1.0f)));
  const double scale = logistic_scale_of(hair.radial_roughness);
  return round_fiber({coated, 0.5 * all, 2 * all}, {scale, scale}, hair.widths);
}

/// Clamps into [0, 1]; NaN becomes 0.
float share(float x) { return std::fmin(std::fmax(x, 0.0f), 1.0f); }

}  // namespace

FiberParameters fiber_of(const PrincipledHair& hair) {
  FiberParameters fiber;
  if (hair.aspect_ratio) {
    fiber.eccentricity = within(eccentricity_range, double{*hair.aspect_ratio});
    fiber.roughness = within(roughness_range, double{hair.roughness});
  } else {
    fiber = round_fiber(hair);
  }
  fiber.eta = within(eta_range, double{hair.eta});
  fiber.tilt = angle_within(tilt_range_deg, double{hair.offset});
  fiber.sigma_a = hair.sigma_a;
  return fiber;
}

FiberParameters fiber_of(const ChiangHair& hair) {
  std::array<double, 3> deviations{};
  for (std::size_t p = 0; p < deviations.size(); ++p)
    deviations[p] = std::sqrt(std::max(double{hair.longitudinal_variance[p]}, 0.0));
  const double to_scale = std::sqrt(std::numbers::pi / 8);
  FiberParameters fiber = round_fiber(
      deviations, {to_scale * hair.azimuthal_scale[1], to_scale * hair.azimuthal_scale[2]}, PrincipledWidths::by_model);
  for (std::size_t p = 0; p < fiber.gain.size(); ++p) fiber.gain[p] = hair.tint[std::min<std::size_t>(p, 2)];
  fiber.eta = within(eta_range, double{hair.eta});
  fiber.tilt = angle_within(tilt_range_deg, std::numbers::pi * (double{hair.cuticle_angle} - 0.5));
  fiber.sigma_a = hair.sigma_a;
  return fiber;
}

glm::vec3 sigma_a_of_principled_color(const glm::vec3& color, float radial_roughness) {
  glm::vec3 valid;
  for (int c = 0; c < 3; ++c) valid[c] = std::fmin(std::fmax(color[c], 1e-5f), 1.0f);
  return sigma_a_from_color(valid, double{share(radial_roughness)});
}

glm::vec3 sigma_a_of_principled_melanin(float melanin, float redness) {
  const float amount = -std::log(std::max(1 - share(melanin), 1e-4f));
  redness = share(redness);
  return amount * ((1 - redness) * glm::vec3(0.506f, 0.841f, 1.653f) + redness * glm::vec3(0.343f, 0.733f, 1.924f));
}

}  // namespace tress::inline v0_2::fiber
