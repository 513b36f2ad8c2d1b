// Mixture of circular skew logistics and a uniform part: the fit of a row.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>

namespace tress::inline v0_2::adaptive {

// Every function here is finite for every number: uniforms and shares are clamped, NaN counts as 0, and an angle that
// is not finite as -pi.

/// Does what wrap_angle() does for an angle that is out of range.
float wrap_turns(float x);
/// Wraps an angle into [-pi, pi).
inline float wrap_angle(float x) {
  constexpr float pi = std::numbers::pi_v<float>;
  return x >= -pi && x < pi ? x : wrap_turns(x);
}

/// One circular skew logistic (ESTIMATOR.md, E1): with x = wrap(phi - mu), s = s_left for x < 0 else s_right,
/// E = exp(-|x|/s):  p = E/(1+E)^2 / Z,  Z = (s_l T(s_l) + s_r T(s_r))/2,  T(s) = tanh(pi/(2s)). Mass 1 on the circle.
struct SkewLogistic {
  float mu = 0;       ///< mode, radians in [-pi, pi)
  float s_left = 1;   ///< scale for x < 0, radians, [0.004, 0.5]
  float s_right = 1;  ///< scale for x >= 0

  /// The density in 1/rad, never negative.
  float density(float phi) const;
  /// Inverse CDF of u in [0, 1). Radians in [-pi, pi).
  float sample(float u) const;
};

/// A component of a mixture; `weight` is its mass.
struct Component {
  SkewLogistic shape;
  float weight = 0;
  float attribute_mean = 0;      ///< over the traced rays it is responsible for (known once converged)
  float attribute_variance = 0;  ///< over the same rays
};

/// The share of a weight that remains where each ray loses the factor exp(-rate attribute): the gamma law of the
/// attribute's moments, (1 + rate v/l)^(-l^2/v), or exp(-rate l) for v -> 0 (ESTIMATOR.md, E1). rate >= 0, in 1/unit of
/// the attribute (hair: the absorption). The result is in [0, 1].
double decayed_share(double rate, double attribute_mean, double attribute_variance);

/// f(x) = sum_d weight_d p_d(x) + uniform_weight / 2 pi. Plain data; at most 8 components.
struct Mixture {
  static constexpr int max_components = 8;
  std::array<Component, max_components> components{};
  std::uint32_t component_count = 0;
  float uniform_weight = 0;  ///< a_0, mass of the uniform part, >= 0
  float uniform_attribute_mean = 0;
  float uniform_attribute_variance = 0;

  std::span<const Component> parts() const { return {components.data(), component_count}; }
  /// Total mass, a_0 included.
  float energy() const;
  /// f in 1/rad; phi in radians, any turn.
  float density(float phi) const;
  /// The density from which sample() draws: (1 - u_share) f/energy + u_share/2 pi, in 1/rad. Uniform if energy is 0; >
  /// 0 for u_share > 0.
  float proposal_density(float phi, float u_share) const;
  /// The same, from the density() there: half the cost of both.
  float proposal_density_at(float density, float u_share) const;
  /// Draws from proposal_density(., u_share). u in [0, 1); all its bits are used. Radians in [-pi, pi). Cannot fail.
  float sample(float u, float u_share) const;
};

/// An azimuth, radians in [-pi, pi), with the density of a mixture and that of its draws there, both in 1/rad.
struct MixtureDraw {
  float azimuth, density, pdf;
};

/// A mixture in as little memory as its components need, as a table keeps it. Its densities are those of the original
/// mixture to the bit; attributes are rounded to 8 bits behind the point (by 0.2 % at most). It cannot be moved,
/// because its components follow it in memory.
class PackedMixture {
 public:
  static constexpr std::size_t bytes_of(std::uint32_t components) {
    return sizeof(PackedMixture) + components * sizeof(Part);
  }
  /// Places a mixture in `memory`, which must have bytes_of(fit.component_count) bytes and the alignment of a float.
  /// Attributes finite, >= 0. objective: the known error of the fit, as in RowView::objective.
  static PackedMixture* put(void* memory, const Mixture& fit, float objective);
  PackedMixture(const PackedMixture&) = delete;
  PackedMixture& operator=(const PackedMixture&) = delete;

  operator Mixture() const;

  float objective;
  float uniform_weight;
  std::uint32_t component_count;

  // These do the same as in Mixture.
  float energy() const;
  float density(float phi) const;
  float proposal_density(float phi, float u_share) const;
  float proposal_density_at(float density, float u_share) const;
  float sample(float u, float u_share) const;
  /// sample() with density() and proposal_density() there, at less cost and to the bit.
  MixtureDraw draw(float u, float u_share) const;

  std::size_t bytes() const { return bytes_of(component_count); }

 private:
  /// The attribute's mean and variance, each as the upper 16 bits of a float without its sign.
  struct Attribute {
    std::uint16_t mean, variance;
  };
  struct Part {
    SkewLogistic shape;
    float weight;
    Attribute attribute;
  };
  static_assert(sizeof(Part) == 20);

  explicit PackedMixture(const Mixture& fit, float known_objective);
  static Attribute rounded(float mean, float variance);
  std::span<const Part> parts() const { return {reinterpret_cast<const Part*>(this + 1), component_count}; }

  Attribute uniform_attribute_;
};
static_assert(sizeof(PackedMixture) == 16);

}  // namespace tress::inline v0_2::adaptive
