#include "references/models/pekelis2015_terms.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/pi.h"
#include "fiber/fresnel.h"

namespace tress::inline v0_2::fiber {
namespace {

constexpr float smallest_sigma = 0.01f, smallest_scale = 0.01f, darkest_color = 1e-30f;

/// sin(pi/2 sigma), the mass that is left within +-pi, for sigma > 1.
float reflection_mass(float sigma) { return sigma > 1 ? std::sin(0.5f * pi_f / sigma) : 1.0f; }

}  // namespace

float pekelis_reflection(float phi, float sigma) {
  const float s = std::max(sigma, smallest_sigma);
  const float half = std::abs(phi) / (2 * s);
  return half < 0.5f * pi_f ? std::cos(half) / (4 * s * reflection_mass(s)) : 0.0f;
}

float sample_pekelis_reflection(float u, float sigma) {
  const float s = std::max(sigma, smallest_sigma);
  return std::clamp(2 * s * std::asin(std::clamp((2 * u - 1) * reflection_mass(s), -1.0f, 1.0f)), -pi_f, pi_f);
}

float pekelis_transmission_scale(float eta_prime, PekelisReading reading) {
  const float corrected = 1 - 1 / eta_prime;
  if (reading == PekelisReading::corrected) return corrected;
  const float tau = std::asin(1 / eta_prime);
  const float d = (std::numbers::sqrt2_v<float> - tau) / (1 - tau);
  const float printed = -0.5f * pi_f * corrected * std::log(2 * d - 1 - 2 * std::sqrt(d * (d - 1)));
  return std::isfinite(printed) && printed > 0 ? printed : corrected;
}

adaptive::SkewLogistic pekelis_transmission(float scale) {
  const float s = std::max(scale, smallest_scale);
  return {-pi_f, s, s};
}

glm::vec3 pekelis_zeta(const glm::vec3& color, PekelisReading reading) {
  glm::vec3 zeta;
  const float largest = reading == PekelisReading::corrected ? 2.0f : 1.0f;
  for (int c = 0; c < 3; ++c) zeta[c] = -std::log(std::clamp(color[c], darkest_color, 1.0f)) / largest;
  return zeta;
}

PekelisAttenuation::PekelisAttenuation(float eta, float theta_d, const glm::vec3& zeta, PekelisReading reading)
    : eta_(eta), cos_theta_d_(std::max(std::cos(theta_d), 1e-6f)), zeta_(zeta) {
  const float sine = std::sin(theta_d);
  eta_prime_ = static_cast<float>(bravais_index(static_cast<double>(eta), static_cast<double>(theta_d)));
  inverse_cosine_ =
      reading == PekelisReading::corrected ? 2 / std::sqrt(1 - sine * sine / (eta * eta)) : 1 / cos_theta_d_;
}

glm::vec3 PekelisAttenuation::operator()(int order, float cos_gamma) const {
  const float cosine = std::clamp(cos_gamma, 0.0f, 1.0f), in_space = cos_theta_d_ * cosine;
  double cos_inside;
  const auto eta = static_cast<double>(eta_);
  const auto f = static_cast<float>(fresnel_entering(eta, eta, static_cast<double>(in_space), &cos_inside));
  const float kept = (1 - f) * (1 - f) * (order == 2 ? f : 1.0f);
  const float sin_t = std::sqrt(1 - cosine * cosine) / eta_prime_;
  const float length = static_cast<float>(order) * std::sqrt(1 - sin_t * sin_t) * inverse_cosine_;
  return kept * glm::vec3(std::exp(-zeta_.x * length), std::exp(-zeta_.y * length), std::exp(-zeta_.z * length));
}

}  // namespace tress::inline v0_2::fiber
