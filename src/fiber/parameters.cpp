#include "tress/fiber/parameters.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/pi.h"
#include "fiber/lobe_widths.h"

namespace tress::inline v0_2::fiber {
namespace {

constexpr float largest_width = static_cast<float>(45 * degree);

}  // namespace

std::array<float, 3> azimuthal_sigmas(const FiberParameters& fiber) {
  constexpr std::array<float, 3> per_alpha{0.5f, 1.8f, 3.0f};
  std::array<float, 3> sigma{};
  for (std::size_t i = 0; i < 3; ++i) {
    sigma[i] = fiber.azimuthal_sigma[i].value_or(std::min(per_alpha[i] * fiber.roughness, largest_width));
  }
  return sigma;
}

float longitudinal_lambda(const FiberParameters& fiber, int p, float theta_r) {
  return LobeWidths(fiber).at(theta_r).lambda[LobeWidths::lane_of(p)];
}

float lobe_tilt(const FiberParameters& fiber, int p) { return LobeWidths(fiber).at(0).tilt[LobeWidths::lane_of(p)]; }

float roughness_shift(const FiberParameters& fiber, int p, float theta_r) {
  return LobeWidths(fiber).at(theta_r).shift[LobeWidths::lane_of(p)];
}

glm::vec3 sigma_a_from_color(const glm::vec3& color, double radial_roughness) {
  const double b = radial_roughness;
  const double denominator =
      5.969 - 0.215 * b + 2.532 * b * b - 10.73 * b * b * b + 5.574 * b * b * b * b + 0.245 * b * b * b * b * b;
  glm::vec3 sigma_a(0.0f);
  for (int c = 0; c < 3; ++c) {
    const double root = std::log(std::clamp(static_cast<double>(color[c]), 1e-6, 1.0)) / denominator;
    sigma_a[c] = static_cast<float>(root * root);
  }
  return sigma_a;
}

glm::vec3 sigma_a_from_melanin(float eumelanin, float pheomelanin) {
  return eumelanin * glm::vec3(0.419f, 0.697f, 1.37f) + pheomelanin * glm::vec3(0.187f, 0.4f, 1.05f);
}

double curl_type(double eccentricity) {
  const double x = 1 / eccentricity - 1.474;
  return std::clamp(std::exp(1.105 + x * (1.977 + x * (4.032 + x * 10.039))), 1.0, 8.0);
}

double curl_diameter_cm(double eccentricity) {
  constexpr std::array<double, 6> type{1, 2, 3, 4, 5, 8};
  constexpr std::array<double, 6> diameter{45, 8.25, 4.40, 2.15, 1.20, 0.20};
  const double t = curl_type(eccentricity);
  std::size_t i = 0;
  while (i + 2 < type.size() && t > type[i + 1]) ++i;
  return diameter[i] + (diameter[i + 1] - diameter[i]) * (t - type[i]) / (type[i + 1] - type[i]);
}

double major_axis_rotation(double length_cm, double curl_diameter_cm) {
  constexpr double turn = 2 * std::numbers::pi;
  const double angle = std::fmod(2 * length_cm / curl_diameter_cm, turn);
  return angle < 0 ? angle + turn : angle;
}

double major_semi_axis(double radius, double eccentricity) {
  const double modulus = std::sqrt(std::max(1 - eccentricity * eccentricity, 0.0));
  return radius * std::numbers::pi / (2 * std::comp_ellint_2(modulus));
}

float projected_half_width(float phi, float eccentricity) {
  const float s = std::sin(phi), c = eccentricity * std::cos(phi);
  return std::sqrt(s * s + c * c);
}

}  // namespace tress::inline v0_2::fiber
