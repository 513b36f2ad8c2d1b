#include "references/models/ou2012_lobes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/exp_of_negative.h"
#include "base/pi.h"
#include "base/quarter_sine.h"
#include "fiber/circle_ray.h"
#include "fiber/cross_section.h"
#include "fiber/longitudinal.h"
#include "tress/adaptive/mixture.h"

namespace tress::inline v0_2::fiber {
namespace {

float gaussian(float x, float width) { return exp_of_negative(-0.5f * (x / width) * (x / width)); }

/// The integral of gaussian() from 0 to x.
float gaussian_mass(float x, float width) {
  constexpr float root_half = std::numbers::sqrt2_v<float> / 2;
  return width * (root_half / std::numbers::inv_sqrtpi_v<float>)*std::erf(x / width * root_half);
}

}  // namespace

AzimuthalBump::AzimuthalBump(float centre, float width) : centre_(centre), width_(width) {
  from_ = std::atan(-centre / width);
  span_ = std::atan((pi_f - centre) / width) - from_;
}

float AzimuthalBump::height(float phi) const { return gaussian(std::abs(phi) - centre_, width_); }

float AzimuthalBump::mass() const {
  return 2 * (gaussian_mass(pi_f - centre_, width_) + gaussian_mass(centre_, width_));
}

float AzimuthalBump::pdf(float phi) const {
  const float x = (std::abs(phi) - centre_) / width_;
  return 0.5f / (width_ * span_ * (1 + x * x));
}

float AzimuthalBump::sample(float u) const {
  const bool rising = u < 0.5f;
  const float v = rising ? 2 * u : 2 * u - 1;
  const float phi = std::clamp(centre_ + width_ * std::tan(from_ + v * span_), 0.0f, pi_f);
  return adaptive::wrap_angle(rising ? phi : -phi);
}

float LongitudinalBump::height(float theta_r, float theta_i) const {
  // cos theta_d >= cos theta_i / 2 everywhere; rounding must not say otherwise at the poles.
  const float cos_i = quarter_cosine(theta_i), cos_d = quarter_cosine(0.5f * (theta_r - theta_i));
  const float ratio = std::min(cos_i / std::max(cos_d, 1e-9f), 2.0f);
  return gaussian(0.5f * (theta_i + theta_r) - tilt, beta) * ratio * ratio;
}

float LongitudinalBump::mass(float theta_r) const {
  // By 64 midpoints of the part within six widths of the mode; beyond is 1e-8 of it.
  const float from = std::max(-half_pi, 2 * (tilt - 6 * beta) - theta_r);
  const float to = std::min(half_pi, 2 * (tilt + 6 * beta) - theta_r);
  if (!(from < to)) return 0;
  constexpr int points = 64;
  const float step = (to - from) / points;
  float sum = 0;
  for (int i = 0; i < points; ++i) sum += height(theta_r, from + (static_cast<float>(i) + 0.5f) * step);
  return sum * step;
}

LongitudinalMasses::LongitudinalMasses(const LongitudinalBump& bump) {
  for (int i = 0; i <= steps; ++i) {
    const float theta_r = half_pi * (2 * static_cast<float>(i) / steps - 1);
    mass_[static_cast<std::size_t>(i)] = bump.mass(theta_r);
  }
}

float LongitudinalMasses::at(float theta_r) const {
  const float x = std::clamp((theta_r / half_pi + 1) * (0.5f * steps), 0.0f, static_cast<float>(steps));
  const int i = std::min(static_cast<int>(x), steps - 1);
  const float part = x - static_cast<float>(i);
  const auto below = static_cast<std::size_t>(i);
  return (1 - part) * mass_[below] + part * mass_[below + 1];
}

CircleFarField::CircleFarField(float eta, const glm::vec3& sigma_a, float sigma_trt) {
  constexpr int points = 256;  // over half the width: both halves are alike
  const CrossSection section(static_cast<double>(eta), 1, 0, 0);
  double clear_tt = 0, square = 0;
  for (int i = 0; i < points; ++i) {
    const float h = (static_cast<float>(i) + 0.5f) / points;
    const CircleRay ray(eta, 0, h);
    const glm::vec3 one_way = ray.transmittance(sigma_a);
    const float entered = (1 - ray.reflectance) * (1 - ray.reflectance) / points;
    const auto in_glint =
        static_cast<float>(section.glint_share(static_cast<double>(h), static_cast<double>(sigma_trt)));
    const glm::vec3 second = entered * ray.reflectance * one_way * one_way;
    tt += entered * one_way;
    trt += (1 - in_glint) * second;
    glint += in_glint * second;
    const double deflection = double{ray.exit_azimuth(1)} - std::numbers::pi;
    clear_tt += double{entered};
    square += double{entered} * deflection * deflection;
  }
  deviation_tt = static_cast<float>(std::sqrt(square / clear_tt));
  if (eta < 2) {
    const CircleRay ray(eta, 0, std::sqrt((4 - eta * eta) / 3));
    caustic = std::min(std::abs(adaptive::wrap_angle(ray.exit_azimuth(2))), pi_f);
  }
}

}  // namespace tress::inline v0_2::fiber
