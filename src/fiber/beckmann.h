// Microfacets whose slopes are normal (Beckmann): visible normals, and how much of a direction they mask.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <numbers>

#include "tress/base/random.h"

namespace tress::fiber {

/// Slopes with the variance alpha^2/2 along either axis of the surface. Immutable plain data; any thread.
class Beckmann {
 public:
  /// alpha > 0.
  explicit Beckmann(float alpha) : alpha_(alpha) {}

  /// A microfacet's normal, unit, on the side of `normal`, with the density of those that are seen from w:
  /// G1(w) max(w.m, 0) D(m)/(w.normal). w, normal: unit, w.normal > 0. Takes its first pair of uniforms from `u`, and
  /// from `random` what it needs besides. Exact for every w: along w the slope of a visible facet, in alphas, has the
  /// density (c - x) e^{-x^2} for x < c = cot(theta)/alpha, which is drawn from (c + |x|) e^{-x^2}, a normal law or a
  /// Rayleigh law of either sign, and accepted with (c - x)/(c + |x|), at least every second time; across w the slopes
  /// stay normal.
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

  /// The same for w of any inclination: light on its way through the microsurface may come from below the horizon. For
  /// c < 0 the slope along w is c - y, y > 0, with the density y e^{-(y^2 + 2|c|y)}.
  glm::vec3 visible_normal_within(const glm::vec3& w, const glm::vec3& normal, std::array<float, 2> u,
                                  RandomStream& random) const;

  /// Smith's Lambda of a direction of either side: above the horizon G1 = 1/(1 + Lambda); below it Lambda <= -1.
  /// Of a level direction, +-infinity.
  float lambda(float cosine) const;
  /// No less than lambda() of a direction above the horizon, without its error function: e^{c^2} > 1 + c^2 + c^4/2.
  float lambda_at_most(float cosine) const {
    const float sine2 = std::max(1 - cosine * cosine, 1e-12f), c2 = cosine * cosine / (alpha_ * alpha_ * sine2);
    return 0.2823f / (std::sqrt(c2) * (1 + c2 * (1 + 0.5f * c2)));  // 1/(2 sqrt(pi)), rounded up
  }

  /// D: the area of facets about a normal, per steradian and area of the surface. cosine: of its angle to the mean one.
  float facet_area(float cosine) const {
    if (!(cosine > 0)) return 0;
    const float cos2 = cosine * cosine, alpha2 = alpha_ * alpha_;
    return std::exp((1 - 1 / cos2) / alpha2) / (std::numbers::pi_v<float> * alpha2 * cos2 * cos2);
  }
  /// The area of all facets as a direction of either side sees it, >= 0: cosine (1 + Lambda), without its
  /// cancellation. Visible normals m have the density max(w.m, 0) D(m) over it.
  float seen_area(float cosine) const;

  /// Smith's G1: the share of the facets facing a direction that nothing masks. cosine: of its angle to the normal; 0
  /// or less: 0. 1 + erf and the exponential are within 1e-8 of their limits from c = 4 on.
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

}  // namespace tress::fiber
