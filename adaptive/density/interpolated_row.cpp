#include "density/interpolated_row.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "density/near_logarithm.h"
#include "tress/adaptive/mixture.h"

namespace tress::adaptive {
namespace {

constexpr std::size_t main_knots = Ribbon::main_knots, broad_knots = Ribbon::broad_knots;
constexpr std::size_t most_rows = 4;

/// A ribbon of a part, with its weight in the interpolated shape.
struct Parent {
  const Ribbon* ribbon;
  float weight;
  double widen;           ///< ln of the factor on its scales that makes its law look like the row's
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

/// Mixes everything but the azimuth.
RibbonKnot mixed_knot(std::span<const Parent> parents, bool of_main, std::size_t k) {
  RibbonKnot knot{0, 0, 0, 0, 0, {0, 0}};
  double below = 0, above = 0;
  for (const Parent& parent : parents) {
    const RibbonKnot& from =
        of_main ? parent.ribbon->main()[(k + parent.shift) % main_knots] : parent.ribbon->broad()[k];
    const float w = parent.weight;
    knot.density += w * from.density;
    knot.mode += w * from.mode;
    for (std::size_t r = 0; r < knot.decays.size(); ++r) knot.decays[r] += w * from.decays[r];
    const double widen = of_main ? parent.widen : 0, weight = static_cast<double>(w);
    below += weight * (near_log(static_cast<double>(from.scale_below)) + widen);
    above += weight * (near_log(static_cast<double>(from.scale_above)) + widen);
  }
  const auto scale = [](double of) {
    return std::clamp(std::exp(static_cast<float>(of)), Ribbon::least_scale, Ribbon::largest_scale);
  };
  knot.mode = std::clamp(knot.mode, -Ribbon::largest_mode, Ribbon::largest_mode);
  knot.scale_below = scale(below);
  knot.scale_above = scale(above);
  for (float& decay : knot.decays) decay = std::min(decay, 1.0f);
  return knot;
}

Ribbon mixed(std::span<Parent> parents) {
  const Parent& first = *std::ranges::max_element(parents, {}, &Parent::weight);
  constexpr double logistic_over_normal = -0.510825624;  // ln 0.6, the ratio of scales that look alike
  for (Parent& parent : parents) {
    parent.widen = parent.ribbon->main_law() == first.ribbon->main_law() ? 0
                   : first.ribbon->main_law() == HeightLaw::normal       ? -logistic_over_normal
                                                                         : logistic_over_normal;
    parent.shift = &parent == &first ? 0 : best_shift(first.ribbon->main(), parent.ribbon->main());
  }
  std::array<RibbonKnot, main_knots> main;
  std::array<RibbonKnot, broad_knots> broad;
  for (std::size_t k = 0; k < main_knots; ++k) {
    main[k] = mixed_knot(parents, true, k);
    const RibbonKnot& here = first.ribbon->main()[k];
    float way = 0;
    for (const Parent& parent : parents)
      way += parent.weight * apart(here, parent.ribbon->main()[(k + parent.shift) % main_knots]);
    main[k].azimuth = wrap_angle(here.azimuth + way);
  }
  if (!std::ranges::is_sorted(main, {}, &RibbonKnot::azimuth)) std::ranges::sort(main, {}, &RibbonKnot::azimuth);
  for (std::size_t k = 0; k < broad_knots; ++k) {
    broad[k] = mixed_knot(parents, false, k);
    broad[k].azimuth = first.ribbon->broad()[k].azimuth;
  }
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

}  // namespace tress::adaptive
