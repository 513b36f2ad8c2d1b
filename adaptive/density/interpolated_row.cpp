#include "density/interpolated_row.h"

#include <algorithm>
#include <cstddef>
#include <numbers>

#include "density/layer_mix.h"
#include "tress/adaptive/mixture.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr std::size_t main_knots = Ribbon::main_knots, broad_knots = Ribbon::broad_knots;
constexpr std::size_t most_rows = 4;

/// A ribbon of a part, with its weight in the interpolated shape.
struct Parent {
  const Ribbon* ribbon;
  float weight;
  float widen;            ///< ln of the factor on its scales that makes its law look like the row's
  std::size_t shift = 0;  ///< its main knot k + shift is paired with the row's knot k
};

/// The signed angle from one knot's azimuth to another's, the shorter way round.
float apart(const RibbonKnot& from, const RibbonKnot& to) { return wrap_angle(to.azimuth - from.azimuth); }

/// Where light has moved over the cut at -pi, the knots are numbered differently. Returns the shift that moves them
/// least, if it moves them far less than no shift, which does not happen by chance.
std::size_t best_shift(std::span<const RibbonKnot> of, std::span<const RibbonKnot> to) {
  constexpr std::size_t farthest = 4;
  constexpr float far_less = 0.5f;
  constexpr float near_enough = 0.3f;  // radians squared, over all knots, which are 0.2 apart
  float least = 0;
  std::size_t best = 0;
  for (std::size_t i = 0; i <= 2 * farthest; ++i) {
    const std::size_t shift = i % 2 == 1 ? (i + 1) / 2 : (main_knots - i / 2) % main_knots;
    float sum = 0;
    for (std::size_t k = 0; k < main_knots; ++k) {
      const float way = apart(of[k], to[(k + shift) % main_knots]);
      sum += way * way;
    }
    if (i == 0 || sum < least) {
      least = i == 0 ? far_less * sum : sum;
      best = shift;
    }
    if (i == 0 && sum < near_enough) break;
  }
  return best;
}

/// A layer made of those of the parents: everything but the azimuths.
template <std::size_t count>
std::array<RibbonKnot, count> mixed_layer(std::span<const Parent> parents,
                                          std::span<const RibbonKnot> (Ribbon::*layer)() const) {
  static constexpr bool is_main = count == main_knots;
  std::array<LayerPart<count>, most_rows> parts;
  for (std::size_t i = 0; i < parents.size(); ++i) {
    const Parent& parent = parents[i];
    parts[i] = {(parent.ribbon->*layer)().data(), is_main ? parent.shift : 0, parent.weight,
                is_main ? parent.widen : 0};
  }
  std::array<RibbonKnot, count> knots;
  mix_layers(std::span<const LayerPart<count>>(parts).first(parents.size()), knots);
  return knots;
}

Ribbon mixed(std::span<Parent> parents) {
  const Parent& first = *std::ranges::max_element(parents, {}, &Parent::weight);
  constexpr float logistic_over_normal = -0.510825624f;  // ln 0.6, the ratio of scales that look alike
  for (Parent& parent : parents) {
    parent.widen = parent.ribbon->main_law() == first.ribbon->main_law() ? 0
                   : first.ribbon->main_law() == HeightLaw::normal       ? -logistic_over_normal
                                                                         : logistic_over_normal;
    parent.shift = &parent == &first ? 0 : best_shift(first.ribbon->main(), parent.ribbon->main());
  }
  std::array<RibbonKnot, main_knots> main = mixed_layer<main_knots>(parents, &Ribbon::main);
  std::array<RibbonKnot, broad_knots> broad = mixed_layer<broad_knots>(parents, &Ribbon::broad);
  for (std::size_t k = 0; k < main_knots; ++k) {
    const RibbonKnot& here = first.ribbon->main()[k];
    float way = 0;
    for (const Parent& parent : parents)
      way += parent.weight * apart(here, parent.ribbon->main()[(k + parent.shift) % main_knots]);
    main[k].azimuth = wrap_angle(here.azimuth + way);
  }
  if (!std::ranges::is_sorted(main, {}, &RibbonKnot::azimuth)) std::ranges::sort(main, {}, &RibbonKnot::azimuth);
  for (std::size_t k = 0; k < broad_knots; ++k) broad[k].azimuth = first.ribbon->broad()[k].azimuth;
  return Ribbon(main, first.ribbon->main_law(), broad);
}

}  // namespace

RibbonRow interpolate_rows(std::span<const WeightedRow> rows) {
  const std::uint32_t count = rows.front().row->parts;
  std::array<RibbonRow::Part, RibbonRow::most_parts> parts;
  for (std::uint32_t p = 0; p < count; ++p) {
    std::array<Parent, most_rows> parents;
    std::size_t n = 0;
    float all = 0;
    for (const WeightedRow& of : rows.first(std::min(rows.size(), most_rows))) {
      if (!(of.weight > 0) || p >= of.row->parts || !(of.row->mass[p] > 0)) continue;
      parts[p].mass += of.weight * of.row->mass[p];
      parents[n++] = {&of.row->ribbon[p], of.weight, 0};
      all += of.weight;
    }
    if (n == 0) continue;
    for (Parent& parent : std::span(parents).first(n)) parent.weight /= all;
    parts[p].ribbon = n == 1 ? *parents[0].ribbon : mixed(std::span(parents).first(n));
  }
  return RibbonRow(std::span(parts).first(count));
}

}  // namespace tress::inline v0_2::adaptive
