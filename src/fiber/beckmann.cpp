#include "fiber/beckmann.h"

#include <limits>

namespace tress::inline v0_2::fiber {

glm::vec3 Beckmann::visible_normal_within(const glm::vec3& w, const glm::vec3& normal, std::array<float, 2> u,
                                          RandomStream& random) const {
  constexpr float two_pi = 2 * std::numbers::pi_v<float>;
  const float cosine = glm::dot(w, normal);
  if (cosine > 1e-4f) return visible_normal(w, normal, u, random);
  const glm::vec3 flat = w - cosine * normal;
  const float length = glm::length(flat), sine = std::max(length, 1e-6f), c = -cosine / (alpha_ * sine);  // |c|
  const glm::vec3 along = length > 1e-6f ? flat / sine : any_tangent(normal);
  float x;
  if (c < 1) {
    for (;; u[0] = random.next()) {  // Rayleigh's law beyond c, accepted with probability (|x| - c)/|x|
      x = std::sqrt(c * c - std::log(1 - u[0]));
      if (random.next() * x < x - c) break;
    }
  } else {
    for (;; u[0] = random.next()) {  // a gamma law from two exponentials, accepted with probability e^{-y^2}
      const float y = -std::log((1 - u[0]) * (1 - random.next())) / (2 * c);
      x = c + y;
      if (random.next() < std::exp(-y * y)) break;
    }
  }
  const float y = std::sqrt(-std::log(1 - random.next())) * std::cos(two_pi * u[1]);
  return glm::normalize(normal + (alpha_ * x) * along - (alpha_ * y) * glm::cross(normal, along));
}

float Beckmann::seen_area(float cosine) const {
  const double x = cosine, spread = static_cast<double>(alpha_) * std::sqrt(std::max(1 - x * x, 0.0));
  if (!(spread > 0)) return std::max(cosine, 0.0f);
  const double c = x / spread;
  const double area = 0.5 * c * std::erfc(-c) + std::exp(-c * c) / (2 * 1.7724538509055159);
  return static_cast<float>(spread * std::max(area, 0.0));
}

float Beckmann::lambda(float cosine) const {
  const float sine = std::sqrt(std::max(1 - cosine * cosine, 0.0f));
  if (!(sine > 0)) return cosine > 0 ? 0.0f : -1.0f;
  const float c = cosine / (alpha_ * sine);
  if (std::abs(c) < 1e-6f) return std::copysign(std::numeric_limits<float>::infinity(), cosine);
  if (c > 4) return 0;
  if (c < -4) return -1;
  return 0.5f * (std::erf(c) - 1) + std::exp(-c * c) / (2 * 1.77245385f * c);
}

}  // namespace tress::inline v0_2::fiber
