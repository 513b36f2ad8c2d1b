// Mixture of circular skew logistics plus a uniform part: what a row is fitted with.
#pragma once

#include <array>
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
  float s_left = 1;   ///< scale for x < 0, radians, [.004, .5]
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

}  // namespace tress::adaptive
