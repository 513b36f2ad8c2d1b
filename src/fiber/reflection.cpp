#include "fiber/reflection.h"

#include <algorithm>
#include <cmath>

#include "tress/adaptive/mixture.h"

namespace tress::fiber {

ReflectionLobe::ReflectionLobe(float eta, float eccentricity, float theta_r, float phi_r, float energy, float tilt,
                               float lambda, ReflectionFresnel fresnel, LongitudinalShape longitudinal_shape)
    : fresnel_(eta, std::clamp(theta_r, -half_pi, half_pi), fresnel),
      eccentricity_(eccentricity),
      theta_r_(theta_r),
      phi_r_(phi_r),
      tilt_(tilt),
      lambda_(lambda),
      cos_phi_(std::cos(phi_r)),
      sin_phi_(std::sin(phi_r)),
      shape_(longitudinal_shape) {
  const float across = eccentricity * cos_phi_;
  inverse_width_ = 1 / std::sqrt(sin_phi_ * sin_phi_ + across * across);
  const float lost = 1 - std::clamp(energy, 0.0f, 1.0f);
  grazing_share_ = 0.5f * lost * lost;
}

ReflectionLobe::At ReflectionLobe::at(float phi_i) const {
  // The ellipse parameter of the point with normal nu has cosine cos nu / s and sine e sin nu / s, that of the ray
  // with h = 0 has e cos phi_r / w and sin phi_r / w; h is the sine of their difference, dt/dnu = e / s^2.
  const float half = 0.5f * adaptive::wrap_angle(phi_i - phi_r_);
  const Float4 sines = quarter_sine(Float4{half, from_quarter(half), 0, 0});
  const float sin_half = sines[0], cos_half = sines[1];
  const float cos_nu = cos_phi_ * cos_half - sin_phi_ * sin_half;
  const float sin_nu = eccentricity_ * (sin_phi_ * cos_half + cos_phi_ * sin_half);
  const float inverse_s2 = 1 / (cos_nu * cos_nu + sin_nu * sin_nu);
  const float inverse_both = inverse_width_ * std::sqrt(inverse_s2);
  const float rate = 0.25f * eccentricity_ * inverse_s2;  // the density over sqrt(1 - h^2): does not vanish
  const float density = eccentricity_ * cos_half * inverse_both * rate;
  const float offset = (eccentricity_ * sin_nu * cos_phi_ - cos_nu * sin_phi_) * inverse_both;
  // The pdf of |h| = 1 - x^2 diverges at |h| = 1 as 1/sqrt(1 - |h|); with the shape's sqrt(1 - h^2) it is finite.
  const float grazing = 0.5f * rate * std::sqrt(1 + std::min(std::abs(offset), 1.0f));
  return {density * fresnel_(cos_half), (1 - grazing_share_) * density + grazing_share_ * grazing, lambda_ * cos_half};
}

float ReflectionLobe::sample_azimuth(float u) const {
  const float b = grazing_share_;
  float h, cos_h;  // of the angle between the point's ellipse parameter and that of h = 0
  if (u < 1 - b) {
    const float share = u / (1 - b);
    h = 2 * share - 1;
    cos_h = 2 * std::sqrt(std::max(share * (1 - share), 0.0f));
  } else {
    float v = std::min((u - (1 - b)) / b, 1.0f) * 2;
    const float sign = v < 1 ? -1.0f : 1.0f;
    if (v >= 1) v -= 1;
    const float deficit = v * v;  // 1 - |h|
    h = sign * (1 - deficit);
    cos_h = v * std::sqrt(2 - deficit);
  }
  const float cos_0 = eccentricity_ * cos_phi_ * inverse_width_, sin_0 = sin_phi_ * inverse_width_;
  const float x = cos_0 * cos_h - sin_0 * h, y = sin_0 * cos_h + cos_0 * h;
  return adaptive::wrap_angle(2 * std::atan2(y, eccentricity_ * x) - phi_r_);
}

LongitudinalLobe ReflectionLobe::longitudinal(float phi_i) const {
  const float half = 0.5f * adaptive::wrap_angle(phi_i - phi_r_);
  return LongitudinalLobe(theta_r_, tilt_, lambda_ * quarter_cosine(half), shape_);
}

float reflected_energy(ReflectionFresnel fresnel, float eta, float eccentricity, float theta_r, float phi_r) {
  const ReflectionLobe lobe(eta, eccentricity, theta_r, phi_r, 0, 0, smallest_lambda, fresnel);
  if (fresnel == ReflectionFresnel::none || fresnel == ReflectionFresnel::longitudinal) return lobe.fresnel()(1);
  // Over half angles, in panels between the kinks of F. In u, x = u^3 (10 - 15 u + 6 u^2), integrands and their slopes
  // vanish at both ends of a panel, whatever roots F has there: midpoints converge with the fourth power.
  constexpr int nodes = 64;
  const float kink = std::asin(std::min(lobe.fresnel().total_reflection(), 1.0f));
  double sum = 0;
  const auto add_panel = [&](float from, float to) {
    if (!(to > from)) return;
    for (int i = 0; i < nodes; ++i) {
      const float u = (static_cast<float>(i) + 0.5f) / nodes, rest = 1 - u;
      const float half = from + (to - from) * u * u * u * (10 + u * (6 * u - 15));
      const float width = 30 * u * u * rest * rest * (to - from) / nodes;
      sum += static_cast<double>(lobe.energy_density(phi_r + 2 * half) * 2 * width);
    }
  };
  add_panel(-half_pi, -kink);
  add_panel(-kink, kink);
  add_panel(kink, half_pi);
  return static_cast<float>(sum);
}

}  // namespace tress::fiber
