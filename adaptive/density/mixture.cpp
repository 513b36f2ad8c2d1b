#include "tress/adaptive/mixture.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <new>

#include "base/exp_of_negative.h"
#include "base/float4.h"
#include "base/pi.h"
#include "density/unit.h"

namespace tress::inline v0_2::adaptive {
namespace {

// T(s) = tanh(pi/(2s)); 1 in float below s = 0.17, where 2 exp(-pi/s) < 2^-25.
float truncation(float s) {
  if (s < 0.17f) return 1.0f;
  const float e = exp_of_negative(-pi_f / s);
  return (1.0f - e) / (1.0f + e);
}

// One side of a shape as its draws need it.
struct Side {
  double s, e;  // the scale, and exp(-pi/s)
  explicit Side(float scale) : s(scale), e(std::exp(-pi / s)) {}
  // s T(s), twice the side's share of Z. Below 0.23 the first form has the bits of the second for every float.
  double share() const { return s * (s < 0.23 ? 1.0 - 2.0 * e / (1.0 + e) : std::tanh(0.5 * pi / s)); }
  // Returns x >= 0 with mass fraction v of the side's [0, pi] below it: 2 s atanh(v T), computed from 1 - v so that the
  // tail keeps its bits.
  double quantile(double v) const {
    const double t = (1.0 - e) / (1.0 + e);
    const double below_one = std::max((1.0 - v) * t + 2.0 * e / (1.0 + e), 1e-300);
    return std::min(s * std::log((1.0 + v * t) / below_one), pi);
  }
};

// Does the same as SkewLogistic::sample, for a u that has more bits than a float.
float sample_shape(const SkewLogistic& shape, double u) {
  const Side left(shape.s_left), right(shape.s_right);
  const double share_left = left.share(), p_left = share_left / (share_left + right.share());
  const double x =
      u < p_left ? -left.quantile(1.0 - u / p_left) : right.quantile(std::min((u - p_left) / (1.0 - p_left), 1.0));
  return wrap_angle(static_cast<float>(shape.mu + x));
}

float uniform_angle(double u) { return wrap_angle(static_cast<float>((2.0 * u - 1.0) * pi)); }

template <class Parts>
float energy_of(const Parts& parts, float uniform_weight) {
  float sum = uniform_weight;
  for (const auto& part : parts) sum += part.weight;
  return sum;
}

// Does what truncation() does, in lanes.
Float4 truncation(Float4 s) {
  const Float4 e = exp_of_negative(-pi_f / s);
  return s < 0.17f ? splat(1) : (1.0f - e) / (1.0f + e);
}

// Does the same as wrap_angle() of each lane. A turn is two floats here, which gives the bits of wrap_turns() for every
// float within a turn of the circle.
Float4 wrap4(Float4 x) {
  if (any4(~(abs4(x) < 3 * pi_f)))
    return Float4{wrap_angle(x[0]), wrap_angle(x[1]), wrap_angle(x[2]), wrap_angle(x[3])};
  constexpr auto rest = static_cast<float>(two_pi_f - two_pi);
  const Float4 turned = x < 0.0f ? (x + two_pi_f) - rest : (x - two_pi_f) + rest;
  const Int4 is_on_circle = (turned >= -pi_f) & (turned < pi_f), is_out = (x >= pi_f) | (x < -pi_f);
  const Float4 wrapped = is_on_circle ? turned : splat(-pi_f);
  return is_out ? wrapped : x;
}

// Four parts by what they have in common; a part begins with these floats. Beyond the last part its shape is repeated,
// with weight 0: random numbers of parts then cost no mispredicted branches.
struct FourParts {
  Float4 mu, left, right, weight;
  template <class Parts>
  FourParts(const Parts& parts, std::size_t first) {
    const std::size_t last = parts.size() - 1;
    const auto part = [&](std::size_t i) { return load4(parts[std::min(i, last)], 0); };
    mu = part(first), left = part(first + 1), right = part(first + 2), weight = part(first + 3);
    transpose4(mu, left, right, weight);
    const auto count = static_cast<std::int32_t>(parts.size() - first);
    weight = Int4{0, 1, 2, 3} < count ? weight : splat(0);
  }
};

// The sum of weight * shape.density(phi) in the order of the parts, to the bit, four at a time.
template <class Parts>
float density_of(const Parts& parts, float uniform_weight, float phi) {
  float sum = uniform_weight * inverse_two_pi_f;
  for (std::size_t first = 0; first < parts.size(); first += 4) {
    const FourParts four(parts, first);
    const Float4 x = wrap4(phi - four.mu);
    const Float4 e = exp_of_negative(-abs4(x) / (x < 0.0f ? four.left : four.right));
    Float4 z = 0.5f * (four.left + four.right);
    if (any4(max4(four.left, four.right) >= 0.17f))
      z = 0.5f * (four.left * truncation(four.left) + four.right * truncation(four.right));
    const Float4 mass = four.weight * (e / ((1.0f + e) * (1.0f + e) * z));
    for (int i = 0; i < 4; ++i) sum += mass[i];
  }
  return sum;
}

float proposal_density_of(float density, float mass, float u_share) {
  if (!(mass > 0.0f)) return inverse_two_pi_f;
  u_share = unit(u_share);
  return (1.0f - u_share) * density / mass + u_share * inverse_two_pi_f;
}

template <class Parts>
float sample_of(const Parts& parts, float uniform_weight, double mass, float u, float u_share) {
  u = unit(u);
  const double share = unit(u_share);
  if (!(mass > 0.0)) return uniform_angle(u);
  if (u < share) return uniform_angle(u / share);
  double left = (u - share) / (1.0 - share) * mass;  // the mass that is still to be passed over
  for (const auto& part : parts) {
    const double weight = part.weight;
    if (left < weight) return sample_shape(part.shape, left / weight);
    left -= weight;
  }
  if (uniform_weight > 0.0f) return uniform_angle(std::min(left / uniform_weight, 1.0));
  // Rounding of the sum passed over the last component: return its end.
  return parts.empty() ? uniform_angle(u) : sample_shape(parts.back().shape, 1.0);
}

template <class Parts>
MixtureDraw draw_of(const Parts& parts, float uniform_weight, float u, float u_share) {
  const float mass = energy_of(parts, uniform_weight);
  const float x = sample_of(parts, uniform_weight, mass, u, u_share), density = density_of(parts, uniform_weight, x);
  return {x, density, proposal_density_of(density, mass, u_share)};
}

// Rounds a float >= 0 to the nearest one with 8 bits behind the point: drops its sign and its last 15 bits.
std::uint16_t upper_bits(float x) {
  const auto bits = std::bit_cast<std::uint32_t>(x > 0 ? x : 0.0f);
  return static_cast<std::uint16_t>(std::min((bits + 0x4000u) >> 15, 0xfeffu));  // the largest finite one
}

float float_of(std::uint16_t upper) { return std::bit_cast<float>(static_cast<std::uint32_t>(upper) << 15); }

}  // namespace

float wrap_turns(float x) {
  double turns = x < 0 ? -1 : 1;  // the usual case: a difference of two angles
  if (!(std::abs(x) < 3 * pi_f)) turns = std::floor((x + pi) / two_pi);
  const auto r = static_cast<float>(x - two_pi * turns);
  return r >= -pi_f && r < pi_f ? r : -pi_f;
}

float SkewLogistic::density(float phi) const {
  const float x = wrap_angle(phi - mu);
  const float e = exp_of_negative(-std::abs(x) / (x < 0.0f ? s_left : s_right));
  const float z = 0.5f * (s_left * truncation(s_left) + s_right * truncation(s_right));
  return e / ((1.0f + e) * (1.0f + e) * z);
}

float SkewLogistic::sample(float u) const { return sample_shape(*this, unit(u)); }

double decayed_share(double rate, double attribute_mean, double attribute_variance) {
  if (!(rate > 0) || !(attribute_mean > 0)) return 1;
  const double spread = attribute_variance / attribute_mean;
  if (!(rate * spread > 1e-6)) return std::exp(-rate * attribute_mean);
  return std::exp(-attribute_mean / spread * std::log1p(rate * spread));
}

float Mixture::energy() const { return energy_of(parts(), uniform_weight); }
float Mixture::density(float phi) const { return density_of(parts(), uniform_weight, phi); }
float Mixture::proposal_density(float phi, float u_share) const { return proposal_density_at(density(phi), u_share); }
float Mixture::proposal_density_at(float density, float u_share) const {
  return proposal_density_of(density, energy(), u_share);
}
float Mixture::sample(float u, float u_share) const { return sample_of(parts(), uniform_weight, energy(), u, u_share); }

float PackedMixture::energy() const { return energy_of(parts(), uniform_weight); }
float PackedMixture::density(float phi) const { return density_of(parts(), uniform_weight, phi); }
float PackedMixture::proposal_density(float phi, float u_share) const {
  return proposal_density_at(density(phi), u_share);
}
float PackedMixture::proposal_density_at(float density, float u_share) const {
  return proposal_density_of(density, energy(), u_share);
}
float PackedMixture::sample(float u, float u_share) const {
  return sample_of(parts(), uniform_weight, energy(), u, u_share);
}
MixtureDraw PackedMixture::draw(float u, float u_share) const { return draw_of(parts(), uniform_weight, u, u_share); }

PackedMixture::Attribute PackedMixture::rounded(float mean, float variance) {
  return {upper_bits(mean), upper_bits(variance)};
}

PackedMixture::PackedMixture(const Mixture& fit, float known_objective)
    : objective(known_objective),
      uniform_weight(fit.uniform_weight),
      component_count(fit.component_count),
      uniform_attribute_(rounded(fit.uniform_attribute_mean, fit.uniform_attribute_variance)) {}

PackedMixture* PackedMixture::put(void* memory, const Mixture& fit, float objective) {
  auto* packed = new (memory) PackedMixture(fit, objective);
  auto* next = reinterpret_cast<Part*>(packed + 1);
  for (const Component& part : fit.parts()) {
    new (next++) Part{part.shape, part.weight, rounded(part.attribute_mean, part.attribute_variance)};
  }
  return packed;
}

PackedMixture::operator Mixture() const {
  Mixture fit;
  for (const Part& part : parts()) {
    fit.components[fit.component_count++] = {part.shape, part.weight, float_of(part.attribute.mean),
                                             float_of(part.attribute.variance)};
  }
  fit.uniform_weight = uniform_weight;
  fit.uniform_attribute_mean = float_of(uniform_attribute_.mean);
  fit.uniform_attribute_variance = float_of(uniform_attribute_.variance);
  return fit;
}

}  // namespace tress::inline v0_2::adaptive
