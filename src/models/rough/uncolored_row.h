// A row of the rough fiber whose color is given where it is read: by textures and wavelengths.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/exp_of_negative.h"
#include "base/logarithm.h"
#include "models/rough/colored_decays.h"
#include "models/rough/row_energies.h"
#include "tress/adaptive/ribbon.h"
#include "tress/frozen_rows.h"

namespace tress::inline v0_2::fiber {

/// Parts are numbered as by rough_part(). Plain data.
struct alignas(64) UncoloredRow {
  std::array<frozen::Part, rough_parts> part;
  std::array<std::array<float, 3>, rough_parts> corrections;  ///< of RowEnergies
};

inline void put_uncolored_row(const adaptive::DecodedRow& row,
                              const std::array<std::array<float, 3>, rough_parts>& corrections, UncoloredRow& to) {
  to.corrections = corrections;
  for (std::uint32_t p = 0; p < rough_parts; ++p) {
    const adaptive::Ribbon& ribbon = row.ribbon[p];
    to.part[p] = {};
    to.part[p].mass = row.mass[p];
    to.part[p].is_logistic = ribbon.main_law() == adaptive::HeightLaw::logistic ? 1 : 0;
    const auto put = [](std::span<const adaptive::RibbonKnot> knots, frozen::Knot* out) {
      for (const adaptive::RibbonKnot& k : knots) {
        const adaptive::GammaDecay decay = ColoredDecays::law(k.decays);
        *out++ = {k.azimuth, k.density, k.mode, k.scale_below, k.scale_above, decay.shape, decay.scale, 0};
      }
    };
    put(ribbon.main(), to.part[p].main);
    put(ribbon.broad(), to.part[p].broad);
  }
}

/// Adds the density of all light at (x, height), per radian and unit of height, under each absorption to s. weights: of
/// the parts. In lanes over the knots around the place, of which each part has four.
inline void add_spectrum_at(const UncoloredRow& row, float x, float height,
                            const std::array<float, rough_parts>& weights, std::span<const float> sigma_a,
                            std::span<float> s) {
  constexpr std::size_t knots = 4 * rough_parts;
  std::array<float, knots> density, shape, scale, left;
  for (std::size_t p = 0; p < rough_parts; ++p) {
    const frozen::Part& part = row.part[p];
    std::size_t i = 4 * p;
    for (const frozen::detail::Layer& layer : {frozen::detail::main_of(part), frozen::detail::broad_of(part)}) {
      float share = 0;
      const int k = layer.find(x, &share);
      const bool is_logistic = i % 4 != 0 || part.is_logistic != 0;
      const float here =
          weights[p] * part.mass * frozen::detail::height_density(is_logistic, layer.at(k, share), height);
      for (const auto& [knot, of] : {std::pair{&layer.knots[k], 1 - share}, {&layer.after(k), share}}) {
        density[i] = here * of * knot->density;
        shape[i] = knot->shape;
        scale[i++] = knot->scale;
      }
    }
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
    for (std::size_t p = 0; p < rough_parts; ++p) {
      const std::array<float, 3>& at = row.corrections[p];
      const float from = at[is_low ? 0 : 1], to = at[is_low ? 1 : 2];
      s[c] += std::exp(from + share * (to - from)) *
              ((left[4 * p] + left[4 * p + 1]) + (left[4 * p + 2] + left[4 * p + 3]));
    }
  }
}

}  // namespace tress::inline v0_2::fiber
