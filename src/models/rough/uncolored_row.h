// A row of the rough fiber whose color is given where it is read: by textures and wavelengths.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/exp_of_negative.h"
#include "base/logarithm.h"
#include "models/rough/colored_decays.h"
#include "models/rough/rough_lanes.h"
#include "models/rough/rough_row.h"
#include "models/rough/row_energies.h"
#include "tress/adaptive/ribbon.h"

namespace tress::inline v0_2::fiber {

/// Parts are numbered as by rough_part(). Plain data.
struct UncoloredRow {
  struct Knot {
    float density, mode, scale_below, scale_above;
    adaptive::GammaDecay decay;
  };
  struct alignas(64) Part {
    RoughPart::Azimuths azimuth;
    std::array<Knot, RoughPart::main_knots> main;
    std::array<Knot, RoughPart::broad_knots> broad;
    float mass;
    bool is_normal;  ///< the law of the main layer
  };
  std::array<Part, rough_parts> part;
  std::array<std::array<float, 3>, rough_parts> corrections;  ///< of RowEnergies
};

/// Copies a row out of its decoded parts. corrections: RowEnergies, logarithms by part and rate.
inline void put_uncolored_row(const adaptive::DecodedRow& row,
                              const std::array<std::array<float, 3>, rough_parts>& corrections, UncoloredRow& to) {
  to.corrections = corrections;
  for (std::uint32_t p = 0; p < rough_parts; ++p) {
    const adaptive::Ribbon& ribbon = row.ribbon[p];
    UncoloredRow::Part& part = to.part[p];
    part.mass = row.mass[p];
    part.is_normal = ribbon.main_law() == adaptive::HeightLaw::normal;
    const auto knot_of = [](const adaptive::RibbonKnot& k) {
      return UncoloredRow::Knot{k.density, k.mode, k.scale_below, k.scale_above, ColoredDecays::law(k.decays)};
    };
    std::ranges::transform(ribbon.main(), part.main.begin(), knot_of);
    std::ranges::transform(ribbon.broad(), part.broad.begin(), knot_of);
    std::ranges::transform(ribbon.main(), part.azimuth.begin(), [](const adaptive::RibbonKnot& k) {
      return static_cast<std::int16_t>(static_cast<int>(azimuth_steps(k.azimuth) + 0.5f) - 32768);
    });
  }
}

/// Adds the density of all light at (x, height), per radian and unit of height, under each absorption to s. weights: of
/// the parts. In lanes over the knots around the place, of which each part has four.
[[gnu::always_inline]] inline void add_spectrum_at(const UncoloredRow& row, float x, float height,
                                                   const std::array<float, rough_parts>& weights,
                                                   std::span<const float> sigma_a, std::span<float> s) {
  constexpr std::size_t knots = 4 * rough_parts;
  std::array<float, knots> density, shape, scale, left;
  const float steps = azimuth_steps(x), in_broad = steps * (static_cast<float>(RoughPart::broad_knots) / 65536);
  const auto b = std::min(static_cast<std::size_t>(in_broad), RoughPart::broad_knots - 1);
  for (std::size_t p = 0; p < rough_parts; ++p) {
    const UncoloredRow::Part& part = row.part[p];
    const float whole = weights[p] * part.mass;
    const auto put = [&](const UncoloredRow::Knot& from, const UncoloredRow::Knot& to, float share, bool is_normal,
                         std::size_t i) {
      const auto line = [share](float at, float end) { return at + share * (end - at); };
      const float mode = line(from.mode, to.mode), below = line(from.scale_below, to.scale_below),
                  above = line(from.scale_above, to.scale_above);
      const float z = std::fabs(height - mode) / (height < mode ? below : above);
      const float e = exp_of_negative(is_normal ? -0.5f * z * z : -z);
      const float law = e * (is_normal ? 0.797884561f : 2 / ((1 + e) * (1 + e))) / (below + above);
      density[i] = whole * law * (1 - share) * from.density;
      density[i + 1] = whole * law * share * to.density;
      shape[i] = from.decay.shape, shape[i + 1] = to.decay.shape;
      scale[i] = from.decay.scale, scale[i + 1] = to.decay.scale;
    };
    const std::size_t k = knot_before(part.azimuth, static_cast<int>(steps));
    const Cell cell = cell_at(part.azimuth, k, steps);
    put(part.main[k], part.main[(k + 1) % RoughPart::main_knots], cell.passed / cell.width, part.is_normal, 4 * p);
    put(part.broad[b], part.broad[(b + 1) % RoughPart::broad_knots], in_broad - static_cast<float>(b), false,
        4 * p + 2);
  }
  constexpr float first = adaptive::Ribbon::decay_rates[0], per_log = 0.558110627f;  // 1 / ln of the ratio of the rates
  for (std::size_t c = 0; c < s.size(); ++c) {
    const float rate = sigma_a[c];
    for (std::size_t i = 0; i < knots; ++i) {
      const float y = scale[i] * rate, above = 1 + y;  // ln(1 + y), also where 1 + y is rounded
      const float logarithm = above > 1 ? natural_log(above) * (y / (above - 1)) : y;
      left[i] = density[i] * exp_of_negative(-shape[i] * logarithm);
    }
    const bool is_low = rate <= first;
    const float share = is_low ? rate / first : std::fmin(natural_log(rate / first) * per_log, 1.0f);
    std::array<float, rough_parts> factor;
    for (std::size_t p = 0; p < rough_parts; ++p) {
      const std::array<float, 3>& at = row.corrections[p];
      const float from = at[is_low ? 0 : 1], to = at[is_low ? 1 : 2];
      factor[p] = 2980.95799f * exp_of_negative(from + share * (to - from) - 8);  // e^8: corrections are of either sign
    }
    for (std::size_t p = 0; p < rough_parts; ++p)
      s[c] += factor[p] * ((left[4 * p] + left[4 * p + 1]) + (left[4 * p + 2] + left[4 * p + 3]));
  }
}

}  // namespace tress::inline v0_2::fiber
