// Evaluates the parts of a RoughRow, four in lanes, and draws from them. Inlined into the model.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <numbers>

#include "base/arctangent.h"
#include "base/exp_of_negative.h"
#include "base/float4.h"
#include "base/logarithm.h"
#include "base/normal_quantile.h"
#include "base/quarter_sine.h"
#include "models/rough/rough_row.h"

namespace tress::inline v0_2::fiber {

/// An inclination as rows use it. theta within +-pi/2.
struct AxialPlace {
  float cosine;  ///< at least 1e-7
  float height;  ///< asinh tan theta = ln((1 + sin |theta|)/cos theta), with the sign of theta
  explicit AxialPlace(float theta) {
    cosine = std::max(quarter_cosine(theta), 1e-7f);
    const float height_above = natural_log((1 + quarter_sine(std::fabs(theta))) / cosine);
    height = std::copysign(std::max(height_above, 0.0f), theta);
  }
};

/// The inclination of a height: pi/2 - 2 atan exp(-|height|), with its sign.
inline float inclination_of_height(float height) {
  constexpr float half_pi = 0.5f * std::numbers::pi_v<float>;
  return std::copysign(half_pi - 2 * angle_of(exp_of_negative(-std::fabs(height)), 1.0f), height);
}

/// Converts a relative azimuth into 65536ths of a turn from -pi on.
inline float azimuth_steps(float x) {
  constexpr float per_radian = 32768 * std::numbers::inv_pi_v<float>;
  return std::clamp((x + std::numbers::pi_v<float>)*per_radian, 0.0f, 65535.996f);
}

/// The values of a layer between two of its knots, in its units.
struct BetweenKnots {
  Float4 density, law;
};

inline void unpack(const PackedKnot& knot, Float4& low, Float4& high) {
#ifdef __SSE2__
  const __m128i all = _mm_load_si128(reinterpret_cast<const __m128i*>(knot.steps.data()));
  low = _mm_cvtepi32_ps(_mm_unpacklo_epi16(all, _mm_setzero_si128()));
  high = _mm_cvtepi32_ps(_mm_unpackhi_epi16(all, _mm_setzero_si128()));
#else
  for (int i = 0; i < 4; ++i) {
    low[i] = knot.steps[static_cast<std::size_t>(i)];
    high[i] = knot.steps[static_cast<std::size_t>(4 + i)];
  }
#endif
}

inline BetweenKnots between(const PackedKnot& from, const PackedKnot& to, float share) {
  BetweenKnots at, end;
  unpack(from, at.density, at.law);
  unpack(to, end.density, end.law);
  return {at.density + share * (end.density - at.density), at.law + share * (end.law - at.law)};
}

/// The knot of a main layer at or before `steps` (floor of azimuth_steps); the last knot if it is before the first.
inline std::size_t knot_before(const RoughPart::Azimuths& azimuth, int steps) {
  const int at = steps - 32768;
#ifdef __SSE2__
  const __m128i x = _mm_set1_epi16(static_cast<short>(at));
  const auto* knots = reinterpret_cast<const __m128i*>(azimuth.data());
  const auto after = [&](int i) { return _mm_cmpgt_epi16(_mm_load_si128(knots + i), x); };
  const auto low = static_cast<std::uint32_t>(_mm_movemask_epi8(_mm_packs_epi16(after(0), after(1))));
  const auto high = static_cast<std::uint32_t>(_mm_movemask_epi8(_mm_packs_epi16(after(2), after(3))));
  const std::uint64_t mask = low | std::uint64_t{high} << 16 | std::uint64_t{1} << 32;
  return static_cast<std::size_t>(std::countr_zero(mask) - 1) % RoughPart::main_knots;
#else
  const auto above = std::upper_bound(azimuth.begin(), azimuth.end(), at);
  return static_cast<std::size_t>(above - azimuth.begin() + static_cast<std::ptrdiff_t>(RoughPart::main_knots) - 1) %
         RoughPart::main_knots;
#endif
}

/// The distance of `steps` from knot k of a main layer, and the distance to the next knot.
struct Cell {
  float passed, width;
};
inline Cell cell_at(const RoughPart::Azimuths& azimuth, std::size_t k, float steps) {
  const std::size_t next = (k + 1) % RoughPart::main_knots;
  const float from = static_cast<float>(azimuth[k] + 32768);
  const float passed = steps - from, width = static_cast<float>(azimuth[next] - azimuth[k]);
  return {passed < 0 ? passed + 65536 : passed, next == 0 ? width + 65536 : width};
}

inline void transpose(std::array<Float4, 4>& x) {
#ifdef __SSE2__
  __m128 a = x[0], b = x[1], c = x[2], d = x[3];
  _MM_TRANSPOSE4_PS(a, b, c, d);
  x = {a, b, c, d};
#else
  for (int i = 0; i < 4; ++i) {
    for (int j = i + 1; j < 4; ++j) std::swap(x[static_cast<std::size_t>(i)][j], x[static_cast<std::size_t>(j)][i]);
  }
#endif
}

/// Densities of heights (HeightLaw), lanes by part. laws: mode, scale below, scale above.
inline Float4 height_densities(const std::array<Float4, 4>& laws, Float4 height, Int4 is_normal) {
  const Float4 from_mode = height - laws[0];
  const Float4 z = abs4(from_mode) / (from_mode < 0.0f ? laws[1] : laws[2]);
  const Float4 e = exp_of_negative(is_normal ? -0.5f * z * z : -z);
  constexpr float normal_peak = 0.797884561f;  // sqrt(2/pi)
  const Float4 peak = is_normal ? splat(normal_peak) : splat(2.0f);
  const Float4 below = is_normal ? splat(1.0f) : (1 + e) * (1 + e);
  return peak * e / ((laws[1] + laws[2]) * below);
}
inline Float4 logistic_densities(const std::array<Float4, 4>& laws, Float4 height) {
  const Float4 from_mode = height - laws[0];
  const Float4 e = exp_of_negative(-abs4(from_mode) / (from_mode < 0.0f ? laws[1] : laws[2]));
  return 2 * e / ((laws[1] + laws[2]) * ((1 + e) * (1 + e)));
}

/// Density per radian and unit of height of each part at (x, height), by channel in lanes 0 to 2; lane 3 is 0.
inline std::array<Float4, 4> part_densities(const RoughRow& row, float x, float height) {
  const float steps = azimuth_steps(x);
  const int whole = static_cast<int>(steps);
  const auto& parts = row.part;
  const float in_broad = steps * (static_cast<float>(RoughPart::broad_knots) / 65536);
  const auto b = std::min(static_cast<std::size_t>(in_broad), RoughPart::broad_knots - 1);
  const float broad_share = in_broad - static_cast<float>(b);
  std::array<std::size_t, 4> knot;
  Float4 passed, width;
  for (std::size_t p = 0; p < 4; ++p) {
    knot[p] = knot_before(parts[p].azimuth, whole);
    const Cell cell = cell_at(parts[p].azimuth, knot[p], steps);
    passed[static_cast<int>(p)] = cell.passed;
    width[static_cast<int>(p)] = cell.width;
  }
  const Float4 share = passed / width;
  std::array<Float4, 4> main, broad, main_law, broad_law;
  for (std::size_t p = 0; p < 4; ++p) {
    const RoughPart& part = parts[p];
    const BetweenKnots a =
        between(part.main[knot[p]], part.main[(knot[p] + 1) % RoughPart::main_knots], share[static_cast<int>(p)]);
    main[p] = a.density * part.main_units.density;
    main_law[p] = a.law * part.main_units.law + part.main_units.law_from;
    const BetweenKnots c = between(part.broad[b], part.broad[(b + 1) % RoughPart::broad_knots], broad_share);
    broad[p] = c.density * part.broad_units.density;
    broad_law[p] = c.law * part.broad_units.law + part.broad_units.law_from;
  }
  transpose(main_law);
  transpose(broad_law);
  const Float4 heights = splat(height);
  const Float4 m = height_densities(main_law, heights, row.is_normal), w = logistic_densities(broad_law, heights);
  std::array<Float4, 4> density;
  for (std::size_t p = 0; p < 4; ++p) density[p] = m[static_cast<int>(p)] * main[p] + w[static_cast<int>(p)] * broad[p];
  return density;
}

/// A place in a row.
struct RowPlace {
  float azimuth;  ///< radians in [-pi, pi)
  float height;
};

/// Inverts the law's distribution function. u in [0, 1).
inline float draw_height(Float4 law, bool is_normal, float u) {
  constexpr float least = 0x1p-26f;
  const float share_below = law[1] / (law[1] + law[2]);
  const bool is_below = u < share_below;
  const float side = std::clamp(is_below ? u / share_below : (1 - u) / (1 - share_below), least, 1.0f);  // mass beyond
  const float z = is_normal ? -normal_quantile(0.5f * side) : natural_log((2 - side) / side);
  return law[0] + (is_below ? -law[1] : law[2]) * std::max(z, 0.0f);
}

/// The place drawn in a layer: the knot before it, and the share of the way to the next.
struct DrawnCell {
  std::size_t knot;
  float share;
};

/// Finds the cell between `first` and `last` in which the mass `left` is used up. widths: in steps; mixed(): the
/// densities per step.
template <class Mixed, class Width>
DrawnCell pass_cells(std::size_t first, std::size_t last, std::size_t count, float left, const Mixed& mixed,
                     const Width& width) {
  constexpr float below_one = 0.99999994f;
  float from = mixed(first);
  for (std::size_t k = first;; ++k) {
    const float to = mixed((k + 1) % count), mass = 0.5f * width(k) * (from + to);
    if (left < mass || k == last) {
      const float r = mass > 0 ? std::clamp(left / mass, 0.0f, below_one) : 0.5f;
      const float root = std::sqrt(from * from + r * (to - from) * (to + from)), sum = from + root;
      return {k, sum > 0 ? std::min(r * (from + to) / sum, below_one) : r};
    }
    left -= mass;
    from = to;
  }
}

/// Draws from a part for a mix of its channels: weights sum to 1, u in [0, 1).
inline RowPlace draw_place(const RoughPart& part, bool is_normal, const glm::vec3& weights, float u_azimuth,
                           float u_height) {
  constexpr float radians_per_step = 2 * std::numbers::pi_v<float> / 65536;
  constexpr float pi = std::numbers::pi_v<float>;
  const Float4 mix{weights.x * radians_per_step, weights.y * radians_per_step, weights.z * radians_per_step, 0};
  const auto mixed_by = [](const Float4& channels) {
    return [channels](const PackedKnot& knot) {
      Float4 density, law;
      unpack(knot, density, law);
      return sum4(channels * density);
    };
  };
  const float main_mass = weights.x * part.main_mass.x + weights.y * part.main_mass.y + weights.z * part.main_mass.z;
  if (u_azimuth < main_mass) {
    std::size_t group = 0;
    float below = 0;
    for (std::size_t g = 1; g < RoughPart::groups; ++g) {
      const float mass = weights.x * part.below[0][g] + weights.y * part.below[1][g] + weights.z * part.below[2][g];
      group += mass <= u_azimuth ? 1 : 0;
      below = mass <= u_azimuth ? mass : below;
    }
    const auto density = mixed_by(mix * part.main_units.density);
    const auto width = [&part](std::size_t k) {
      const std::size_t next = (k + 1) % RoughPart::main_knots;
      return static_cast<float>(part.azimuth[next] - part.azimuth[k] + (next == 0 ? 65536 : 0));
    };
    const std::size_t first = group * RoughPart::group;
    const DrawnCell at = pass_cells(
        first, first + RoughPart::group - 1, RoughPart::main_knots, u_azimuth - below,
        [&](std::size_t k) { return density(part.main[k]); }, width);
    const PackedKnot& to = part.main[(at.knot + 1) % RoughPart::main_knots];
    const Float4 law = between(part.main[at.knot], to, at.share).law * part.main_units.law + part.main_units.law_from;
    const float steps = static_cast<float>(part.azimuth[at.knot]) + at.share * width(at.knot);  // from 0 on
    const float x = steps * radians_per_step;
    return {x < pi ? x : x - 2 * pi, draw_height(law, is_normal, u_height)};
  }
  constexpr float width = 65536 / static_cast<float>(RoughPart::broad_knots);
  const auto density = mixed_by(mix * part.broad_units.density);
  const DrawnCell at = pass_cells(
      0, RoughPart::broad_knots - 1, RoughPart::broad_knots, u_azimuth - main_mass,
      [&](std::size_t k) { return density(part.broad[k]); }, [](std::size_t) { return width; });
  const PackedKnot& to = part.broad[(at.knot + 1) % RoughPart::broad_knots];
  const Float4 law = between(part.broad[at.knot], to, at.share).law * part.broad_units.law + part.broad_units.law_from;
  const float steps = (static_cast<float>(at.knot) + at.share) * width;
  return {std::min(steps * radians_per_step - pi, 3.14159250f), draw_height(law, false, u_height)};
}

}  // namespace tress::inline v0_2::fiber
