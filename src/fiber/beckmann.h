// Microfacets with normally distributed slopes (Beckmann): their visible normals, and their masking.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <numbers>

#include "tress/base/random.h"

namespace tress::inline v0_2::fiber {

/// Slopes with variance alpha^2/2 along either axis of the surface. Immutable plain data; any thread.
class Beckmann {
 public:
  /// alpha > 0.
  explicit Beckmann(float alpha) : alpha_(alpha) {}

  /// Draws a microfacet's normal, unit, on the side of `normal`, with the density of the normals visible from w: G1(w)
  /// max(w.m, 0) D(m)/(w.normal). w, normal: unit, w.normal > 0. `u` is its first pair of uniforms; more come from
  /// `random`.
  /// Exact for every w. Along w the slope of a visible facet, in alphas, has the density (c - x) e^{-x^2} for x < c =
  /// cot(theta)/alpha. It is drawn from (c + |x|) e^{-x^2}, which is a normal law or a Rayleigh law of either sign, and
  /// accepted with probability (c - x)/(c + |x|), at least 1/2. Across w the slopes stay normal.
  glm::vec3 visible_normal(const glm::vec3& w, const glm::vec3& normal, std::array<float, 2> u,
                           RandomStream& random) const {
    constexpr float two_pi = 2 * std::numbers::pi_v<float>, root_pi = 1.77245385f;
    const float cosine = glm::dot(w, normal);
    const glm::vec3 flat = w - cosine * normal;
    const float sine = glm::length(flat);
    const glm::vec3 along = sine > 1e-6f ? flat / sine : any_tangent(normal), across = glm::cross(normal, along);
    const float steepness = alpha_ * sine / cosine;  // 1/c
    for (;; u = {random.next(), random.next()}) {
      const float radius = std::sqrt(-std::log(1 - u[0])), turn = two_pi * u[1];
      const float y = radius * std::sin(turn);
      float x = radius * std::cos(turn);
      if (random.next() * (root_pi + steepness) < steepness) {
        const float size = std::sqrt(-std::log(1 - random.next()));
        x = random.next() < 0.5f ? -size : size;
      }
      if (x > 0 && !(random.next() * (1 + x * steepness) < 1 - x * steepness)) continue;
      return glm::normalize(normal - (alpha_ * x) * along - (alpha_ * y) * across);
    }
  }

  /// The same for w of any inclination, because light within the microsurface may come from below the horizon. For c <
  /// 0 the slope along w is c - y, y > 0, with the density y e^{-(y^2 + 2|c|y)}.
  glm::vec3 visible_normal_within(const glm::vec3& w, const glm::vec3& normal, std::array<float, 2> u,
                                  RandomStream& random) const;

  /// Smith's Lambda of a direction on either side. Above the horizon G1 = 1/(1 + Lambda); below it Lambda <= -1. It is
  /// +-infinity for a level direction.
  float lambda(float cosine) const;
  /// An upper bound of lambda() for a direction above the horizon, without its error function: e^{c^2} > 1 + c^2 +
  /// c^4/2.
  float lambda_at_most(float cosine) const {
    const float sine2 = std::max(1 - cosine * cosine, 1e-12f), c2 = cosine * cosine / (alpha_ * alpha_ * sine2);
    return 0.2823f / (std::sqrt(c2) * (1 + c2 * (1 + 0.5f * c2)));  // 1/(2 sqrt(pi)), rounded up
  }

  /// D: the area of facets about a normal, per steradian and area of the surface. cosine: of the normal's angle to the
  /// mean normal.
  float facet_area(float cosine) const {
    if (!(cosine > 1e-5f)) return 0;  // less than the smallest float, whose quotient would be 0 over 0
    const float cos2 = cosine * cosine, alpha2 = alpha_ * alpha_;
    return std::exp((1 - 1 / cos2) / alpha2) / (std::numbers::pi_v<float> * alpha2 * cos2 * cos2);
  }
  /// The projected area of all facets towards a direction on either side, >= 0: cosine (1 + Lambda), without
  /// cancellation. The density of visible normals m is max(w.m, 0) D(m) divided by it.
  float seen_area(float cosine) const;

  /// Smith's G1: the share of the facets facing a direction that are not masked. cosine: of its angle to the normal;
  /// for 0 or less G1 is 0. From c = 4 on, 1 + erf and the exponential are within 1e-8 of their limits.
  float unmasked(float cosine) const {
    if (!(cosine > 0)) return 0;
    const float sine2 = 1 - cosine * cosine, limit = 4 * alpha_;
    if (cosine * cosine >= limit * limit * sine2) return 1;
    const float c = cosine / (alpha_ * std::sqrt(sine2)), scaled = c * 1.77245385f;
    return std::min(2 * scaled / (scaled * (1 + std::erf(c)) + std::exp(-c * c)), 1.0f);
  }

 private:
  static glm::vec3 any_tangent(const glm::vec3& normal) {
    const glm::vec3 axis = std::abs(normal.x) < 0.5f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
    return glm::normalize(glm::cross(normal, axis));
  }

  float alpha_;
};

}  // namespace tress::inline v0_2::fiber
