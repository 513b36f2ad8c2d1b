// Mixture of circular skew logistics plus a uniform part: what a row is fitted with.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>

namespace tress::adaptive {

/// wrap_angle() of an angle that is out of range.
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

  /// 1/rad. Never negative.
  float density(float phi) const;
  /// Inverse CDF of u in [0, 1). Radians in [-pi, pi).
  float sample(float u) const;
};

/// A component of a mixture; `weight` is its mass.
struct Component {
  SkewLogistic shape;
  float weight = 0;
  float attribute_mean = 0;      ///< of the traced rays it is responsible for (known once converged)
  float attribute_variance = 0;  ///< likewise
};

/// Share of a weight that is left where the attribute takes exp(-rate attribute) of it: the gamma law of its moments,
/// (1 + rate v/l)^(-l^2/v), exp(-rate l) for v -> 0 (ESTIMATOR.md, E1). rate >= 0, in 1/unit of the attribute (hair:
/// the absorption). In [0, 1].
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
  /// f, 1/rad, radians in any turn.
  float density(float phi) const;
  /// Density of what sample() draws: (1 - u_share) f/energy + u_share/2 pi. Uniform if energy is 0. 1/rad, > 0 for
  /// u_share > 0.
  float proposal_density(float phi, float u_share) const;
  /// Draws from proposal_density(., u_share). u in [0,1) is used up whole. Radians in [-pi, pi). Cannot fail.
  float sample(float u, float u_share) const;
};

/// A mixture in no more memory than its components take: what a table keeps of a row. Its densities are those of the
/// mixture that it was made of, to the bit; attributes are rounded to 8 bits behind the point (by 0.2 % at most). Lives
/// where it was put, since the components follow it in memory.
class PackedMixture {
 public:
  static constexpr std::size_t bytes_of(std::uint32_t components) {
    return sizeof(PackedMixture) + components * sizeof(Part);
  }
  /// memory: bytes_of(fit.component_count) bytes, aligned as a float is. Attributes finite, >= 0.
  /// objective: how far the fit is known to be from its target, as RowView::objective.
  static PackedMixture* put(void* memory, const Mixture& fit, float objective);
  PackedMixture(const PackedMixture&) = delete;
  PackedMixture& operator=(const PackedMixture&) = delete;

  operator Mixture() const;

  float objective;
  float uniform_weight;
  std::uint32_t component_count;

  // The same as in Mixture.
  float energy() const;
  float density(float phi) const;
  float proposal_density(float phi, float u_share) const;
  float sample(float u, float u_share) const;

  std::size_t bytes() const { return bytes_of(component_count); }

 private:
  /// The attribute's mean and variance as the upper 16 bits of a float without its sign.
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

}  // namespace tress::adaptive
