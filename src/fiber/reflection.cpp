#include "fiber/reflection.h"

#include <algorithm>
#include <cmath>

#include "fiber/fresnel.h"
#include "tress/adaptive/mixture.h"

namespace tress::fiber {

ReflectionLobe::ReflectionLobe(float eta, float eccentricity, float theta_r, float phi_r, float energy, float tilt,
                               float lambda)
    : eta_(eta),
      eta_prime_(static_cast<float>(bravais_index(eta, std::clamp(theta_r, -half_pi, half_pi)))),
      eccentricity_(eccentricity),
      theta_r_(theta_r),
      phi_r_(phi_r),
      tilt_(tilt),
      lambda_(lambda),
      cos_phi_(std::cos(phi_r)),
      sin_phi_(std::sin(phi_r)) {
  const float across = eccentricity * cos_phi_;
  inverse_width_ = 1 / std::sqrt(sin_phi_ * sin_phi_ + across * across);
  const float lost = 1 - std::clamp(energy, 0.0f, 1.0f);
  grazing_share_ = 0.5f * lost * lost;
}

ReflectionLobe::Shape ReflectionLobe::shape(float phi_i) const {
  // The ellipse parameter of the point with normal nu has cosine cos nu / s and sine e sin nu / s, that of the ray
  // with h = 0 has e cos phi_r / w and sin phi_r / w; h is the sine of their difference, dt/dnu = e / s^2.
  const float half = 0.5f * adaptive::wrap_angle(phi_i - phi_r_);
  const float cos_half = std::abs(std::cos(half)), nu = phi_r_ + half;
  const float cos_nu = std::cos(nu), sin_nu = eccentricity_ * std::sin(nu);
  const float inverse_s2 = 1 / (cos_nu * cos_nu + sin_nu * sin_nu), inverse_s = std::sqrt(inverse_s2);
  const float cos_difference = eccentricity_ * cos_half * inverse_width_ * inverse_s;
  const float offset = (eccentricity_ * sin_nu * cos_phi_ - cos_nu * sin_phi_) * inverse_width_ * inverse_s;
  const float rate = 0.25f * eccentricity_ * inverse_s2;
  return {cos_difference * rate, rate, std::clamp(offset, -1.0f, 1.0f), cos_half};
}

float ReflectionLobe::energy_density(float phi_i) const { return energy_density(shape(phi_i)); }
float ReflectionLobe::azimuth_pdf(float phi_i) const { return azimuth_pdf(shape(phi_i)); }

ReflectionLobe::At ReflectionLobe::at(float phi_i) const {
  const Shape at = shape(phi_i);
  return {energy_density(at), azimuth_pdf(at), LongitudinalLobe(theta_r_, tilt_, lambda_ * at.cos_half)};
}

float ReflectionLobe::energy_density(const Shape& at) const {
  double cos_t;
  return at.density * static_cast<float>(fresnel_entering(eta_, eta_prime_, at.cos_half, &cos_t));
}

float ReflectionLobe::azimuth_pdf(const Shape& at) const {
  // The pdf of |h| = 1 - x^2 diverges at |h| = 1 as 1/sqrt(1 - |h|); with the shape's sqrt(1 - h^2) it is finite.
  return (1 - grazing_share_) * at.density + grazing_share_ * 0.5f * at.rate * std::sqrt(1 + std::abs(at.offset));
}

float ReflectionLobe::sample_azimuth(float u) const {
  const float b = grazing_share_;
  double h, cos_h;  // of the angle between the point's ellipse parameter and that of h = 0
  if (u < 1 - b) {
    h = 2 * static_cast<double>(u) / (1 - b) - 1;
    cos_h = std::sqrt(std::max(1 - h * h, 0.0));
  } else {
    double v = std::min((static_cast<double>(u) - (1 - b)) / b, 1.0) * 2;
    const double sign = v < 1 ? -1 : 1;
    if (v >= 1) v -= 1;
    const double deficit = v * v;  // 1 - |h|
    h = sign * (1 - deficit);
    cos_h = v * std::sqrt(2 - deficit);
  }
  const double cos_0 = eccentricity_ * cos_phi_ * inverse_width_, sin_0 = sin_phi_ * inverse_width_;
  const double x = cos_0 * cos_h - sin_0 * h, y = sin_0 * cos_h + cos_0 * h;
  const float nu = static_cast<float>(std::atan2(y, eccentricity_ * x));
  return adaptive::wrap_angle(2 * nu - phi_r_);
}

LongitudinalLobe ReflectionLobe::longitudinal(float phi_i) const {
  const float half = 0.5f * adaptive::wrap_angle(phi_i - phi_r_);
  return LongitudinalLobe(theta_r_, tilt_, lambda_ * std::abs(std::cos(half)));
}

}  // namespace tress::fiber
