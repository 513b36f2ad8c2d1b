#include "fiber/circle_ray.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fiber/fresnel.h"
#include "tress/fiber/parameters.h"

namespace tress::inline v0_2::fiber {

CircleRay::CircleRay(float eta, float theta, float h) {
  const double offset = std::clamp(static_cast<double>(h), -1.0, 1.0), index = static_cast<double>(eta);
  const double eta_prime = bravais_index(index, static_cast<double>(theta));
  double cos_gamma_t;
  reflectance = static_cast<float>(fresnel_entering(index, eta_prime, std::sqrt(1 - offset * offset), &cos_gamma_t));
  gamma = static_cast<float>(std::asin(offset));
  gamma_t = static_cast<float>(std::asin(offset / eta_prime));
  const double sin_theta_t = std::sin(static_cast<double>(theta)) / index;
  path = static_cast<float>(2 * cos_gamma_t / std::sqrt(1 - sin_theta_t * sin_theta_t));
}

float CircleRay::exit_azimuth(int p) const {
  const auto order = static_cast<float>(p);
  return 2 * gamma - 2 * order * gamma_t + order * std::numbers::pi_v<float>;
}

glm::vec3 CircleRay::transmittance(const glm::vec3& sigma_a) const {
  glm::vec3 left;
  for (int c = 0; c < 3; ++c) left[c] = std::exp(-sigma_a[c] * path);
  return left;
}

float circle_radius(float eccentricity) {
  return static_cast<float>(1 / major_semi_axis(1, static_cast<double>(eccentricity)));
}

}  // namespace tress::inline v0_2::fiber
