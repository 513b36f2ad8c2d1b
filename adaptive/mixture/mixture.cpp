#include "tress/adaptive/mixture.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tress/adaptive/exp_of_negative.h"

namespace tress::adaptive {
namespace {

constexpr float pi = std::numbers::pi_v<float>;
constexpr float inverse_two_pi = 0.5f * std::numbers::inv_pi_v<float>;

// T(s) = tanh(pi/(2s)); 1 in float below s = .17, where 2 exp(-pi/s) < 2^-25.
float truncation(float s) {
  if (s < 0.17f) return 1.0f;
  const float e = exp_of_negative(-pi / s);
  return (1.0f - e) / (1.0f + e);
}

// x >= 0 with mass fraction v of the side's [0, pi] below it: 2 s atanh(v T), from 1 - v so that the tail keeps its
// bits.
double side_quantile(double v, double s) {
  const double e = std::exp(-std::numbers::pi / s);
  const double t = (1.0 - e) / (1.0 + e);
  const double below_one = std::max((1.0 - v) * t + 2.0 * e / (1.0 + e), 1e-300);
  return std::min(s * std::log((1.0 + v * t) / below_one), std::numbers::pi);
}

// As SkewLogistic::sample, for a u that has more bits than a float.
float sample_shape(const SkewLogistic& shape, double u) {
  const double left = static_cast<double>(shape.s_left) * std::tanh(0.5 * std::numbers::pi / shape.s_left);
  const double right = static_cast<double>(shape.s_right) * std::tanh(0.5 * std::numbers::pi / shape.s_right);
  const double p_left = left / (left + right);
  const double x = u < p_left ? -side_quantile(1.0 - u / p_left, shape.s_left)
                              : side_quantile(std::min((u - p_left) / (1.0 - p_left), 1.0), shape.s_right);
  return wrap_angle(static_cast<float>(shape.mu + x));
}

float uniform_angle(double u) { return wrap_angle(static_cast<float>((2.0 * u - 1.0) * std::numbers::pi)); }

}  // namespace

float wrap_turns(float x) {
  constexpr double two_pi = 2.0 * std::numbers::pi;
  double turns = x < 0 ? -1 : 1;  // the usual case: a difference of two angles
  if (!(std::abs(x) < 3 * pi)) turns = std::floor((x + std::numbers::pi) / two_pi);
  const auto r = static_cast<float>(x - two_pi * turns);
  return r >= -pi && r < pi ? r : -pi;
}

float SkewLogistic::density(float phi) const {
  float x = phi - mu;
  if (x >= pi || x < -pi) x = wrap_angle(x);
  const float e = exp_of_negative(-std::abs(x) / (x < 0.0f ? s_left : s_right));
  const float z = 0.5f * (s_left * truncation(s_left) + s_right * truncation(s_right));
  return e / ((1.0f + e) * (1.0f + e) * z);
}

float SkewLogistic::sample(float u) const { return sample_shape(*this, u); }

float Mixture::energy() const {
  float sum = uniform_weight;
  for (const Component& part : parts()) sum += part.weight;
  return sum;
}

float Mixture::density(float phi) const {
  float sum = uniform_weight * inverse_two_pi;
  for (const Component& part : parts()) sum += part.weight * part.shape.density(phi);
  return sum;
}

float Mixture::proposal_density(float phi, float u_share) const {
  const float mass = energy();
  if (!(mass > 0.0f)) return inverse_two_pi;
  return (1.0f - u_share) * density(phi) / mass + u_share * inverse_two_pi;
}

float Mixture::sample(float u, float u_share) const {
  const double share = u_share;
  const double mass = energy();
  if (!(mass > 0.0)) return uniform_angle(u);
  if (u < share) return uniform_angle(u / share);
  double left = (u - share) / (1.0 - share) * mass;  // of the mass that is still to be passed over
  for (const Component& part : parts()) {
    const double weight = part.weight;
    if (left < weight) return sample_shape(part.shape, left / weight);
    left -= weight;
  }
  if (uniform_weight > 0.0f) return uniform_angle(std::min(left / uniform_weight, 1.0));
  // Rounding of the sum passed over the last component: its end.
  return component_count > 0 ? sample_shape(components[component_count - 1].shape, 1.0) : uniform_angle(u);
}

}  // namespace tress::adaptive
