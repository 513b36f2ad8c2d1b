#include "tress/adaptive/restricted.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "base/pi.h"
#include "density/invert_line.h"
#include "density/unit.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr double slack = 1e-6;  // radians

/// An angle in [0, 2 pi).
double positive(double x) {
  const double turned = x - two_pi * std::floor(x / two_pi);
  return turned < two_pi ? turned : 0;
}

/// The mass of E/(1 + E)^2, E = exp(-x), between two distances x from the mode.
double between(double nearest, double farthest) {
  const double e = std::exp(-nearest), f = std::exp(-farthest);
  return -e * std::expm1(nearest - farthest) / ((1 + e) * (1 + f));
}

/// Calls visit(k, from, to, width) for the stretches of the segments of a layer inside the arc: from one share of
/// segment k to another, and the width of the segment in radians.
template <class Visit>
void visit_inside(std::span<const RibbonKnot> knots, const Arc& arc, Visit&& visit) {
  for (std::size_t k = 0; k < knots.size(); ++k) {
    const bool is_last = k + 1 == knots.size();
    const double width = static_cast<double>(knots[is_last ? 0 : k + 1].azimuth) -
                         static_cast<double>(knots[k].azimuth) + (is_last ? two_pi : 0.0);
    if (!(width > 0)) continue;
    const double start = positive(static_cast<double>(knots[k].azimuth) - static_cast<double>(arc.from));
    for (const double turn : {0.0, two_pi}) {
      const double from = std::max(turn - start, 0.0) / width;
      const double to = std::min(turn + static_cast<double>(arc.width) - start, width) / width;
      if (to > from) visit(k, from, to, width);
    }
  }
}

double density_at(std::span<const RibbonKnot> knots, std::size_t k, double share) {
  const auto from = static_cast<double>(knots[k].density),
             to = static_cast<double>(knots[k + 1 < knots.size() ? k + 1 : 0].density);
  return from + share * (to - from);
}

double mass_inside(std::span<const RibbonKnot> knots, const Arc& arc) {
  double sum = 0;
  visit_inside(knots, arc, [&](std::size_t k, double from, double to, double width) {
    sum += 0.5 * width * (to - from) * (density_at(knots, k, from) + density_at(knots, k, to));
  });
  return sum;
}

/// The place with `left` of the layer's mass inside the arc before it, by its segment and share of that.
std::pair<std::size_t, double> place_of(std::span<const RibbonKnot> knots, const Arc& arc, double left) {
  std::pair<std::size_t, double> place{0, 0};
  bool is_found = false;
  visit_inside(knots, arc, [&](std::size_t k, double from, double to, double width) {
    if (is_found) return;
    const double a = density_at(knots, k, from), b = density_at(knots, k, to),
                 mass = 0.5 * width * (to - from) * (a + b);
    if (!(mass > 0)) return;
    is_found = left < mass;
    const double r = std::min(left / mass, 1.0);
    place = {k, from + (to - from) * static_cast<double>(invert_line(static_cast<float>(a), static_cast<float>(b),
                                                                     static_cast<float>(r)))};
    left -= mass;
  });
  return place;
}

/// The angle that is `past` the beginning of an arc; `past` is clamped to it.
float angle_in(const Arc& arc, double past) {
  return wrap_angle(
      static_cast<float>(static_cast<double>(arc.from) + std::clamp(past, 0.0, static_cast<double>(arc.width))));
}

}  // namespace

bool Arc::contains(float x) const {
  const Arc arc = clamped();
  const double past = positive(static_cast<double>(x) - static_cast<double>(arc.from));
  return past <= static_cast<double>(arc.width) + slack || past >= two_pi - slack;
}

Arc Arc::clamped() const {
  return {wrap_angle(std::isfinite(from) ? from : 0.0f), width > least_width ? std::min(width, two_pi_f) : least_width};
}

RestrictedMixture::RestrictedMixture(const Mixture& mixture, const Arc& arc)
    : mixture_(mixture), arc_(arc.clamped()), energy_(static_cast<double>(mixture.energy())) {
  for (const Component& part : mixture_.parts()) {
    const auto left = static_cast<double>(part.shape.s_left), right = static_cast<double>(part.shape.s_right);
    const double whole = left * between(0, pi / left) + right * between(0, pi / right);
    const double start = positive(static_cast<double>(arc_.from) - static_cast<double>(part.shape.mu));
    for (int half = 0; half < 4; ++half) {  // half turns from the mode on: right and left of it, in turn
      const double low = std::max(start, half * pi), high = std::min(start + arc_.width, (half + 1) * pi);
      if (!(high > low)) continue;
      const bool is_right = half % 2 == 0;
      const double scale = is_right ? right : left, nearest = is_right ? low - half * pi : (half + 1) * pi - high;
      const double mass =
          static_cast<double>(part.weight) * scale * between(nearest / scale, (nearest + high - low) / scale) / whole;
      pieces_[count_++] = {mass, is_right ? scale : -scale, nearest, nearest + high - low, part.shape.mu};
      inside_ += mass;
    }
  }
  inside_ += static_cast<double>(mixture_.uniform_weight) * arc_.width / two_pi;
}

float RestrictedMixture::density(float x) const {
  if (!arc_.contains(x)) return 0;
  return static_cast<float>(inside_ > 0 ? energy_ / inside_ * static_cast<double>(mixture_.density(x))
                                        : energy_ / arc_.width);
}

float RestrictedMixture::proposal_density(float x, float u_share) const {
  if (!arc_.contains(x)) return 0;
  u_share = unit(u_share);
  const float own = inside_ > 0 ? density(x) / static_cast<float>(energy_) : 1 / arc_.width;
  return (1 - u_share) * own + u_share / arc_.width;
}

float RestrictedMixture::sample(float u, float u_share) const {
  u = unit(u);
  const double share = inside_ > 0 ? static_cast<double>(unit(u_share)) : 1;
  if (u < share) return angle_in(arc_, u / share * arc_.width);
  double left = (u - share) / (1 - share) * inside_;
  for (const Piece& piece : std::span(pieces_).first(count_)) {
    if (!(left < piece.mass)) {
      left -= piece.mass;
      continue;
    }
    const double scale = std::abs(piece.scale);
    const double e = std::exp(-piece.nearest / scale), f = std::exp(-piece.farthest / scale);
    const double k = left / piece.mass * (e - f) / (1 + f);
    const double x = std::clamp(-scale * std::log((e - k) / (1 + k)), piece.nearest, piece.farthest);
    const double past =
        positive(static_cast<double>(piece.mu) + std::copysign(x, piece.scale) - static_cast<double>(arc_.from));
    return angle_in(arc_, past < 0.5 * (arc_.width + two_pi) ? past : 0);  // rounding may lead to before its beginning
  }
  const double uniform = static_cast<double>(mixture_.uniform_weight) * arc_.width / two_pi;
  return angle_in(arc_, uniform > 0 ? left / uniform * arc_.width : arc_.width);
}

RestrictedRibbon::RestrictedRibbon(const Ribbon& ribbon, const Arc& arc)
    : ribbon_(ribbon),
      arc_(arc.clamped()),
      main_(mass_inside(ribbon_.main(), arc_)),
      broad_(mass_inside(ribbon_.broad(), arc_)) {
  share_ = static_cast<float>(std::min(main_ + broad_, 1.0));
  if (main_ + broad_ > 0) return;
  ribbon_ = Ribbon();
  main_ = mass_inside(ribbon_.main(), arc_);
}

float RestrictedRibbon::density(float x, float t) const {
  return arc_.contains(x) ? ribbon_.density(x, t) / static_cast<float>(main_ + broad_) : 0;
}

Ribbon::Place RestrictedRibbon::sample(float u_azimuth, float u_height) const {
  const double v = static_cast<double>(unit(u_azimuth)) * (main_ + broad_);
  const bool is_main = v < main_ || !(broad_ > 0);
  const std::span<const RibbonKnot> knots = is_main ? ribbon_.main() : ribbon_.broad();
  const auto [k, share] = place_of(knots, arc_, is_main ? v : v - main_);
  const RibbonKnot &from = knots[k], &to = knots[k + 1 < knots.size() ? k + 1 : 0];
  const double turn = k + 1 < knots.size() ? 0 : two_pi;
  const double width = static_cast<double>(to.azimuth) - static_cast<double>(from.azimuth) + turn;
  const double past = positive(static_cast<double>(from.azimuth) + share * width - static_cast<double>(arc_.from));
  const auto s = static_cast<float>(share);
  const auto line = [s](float a, float b) { return a + s * (b - a); };
  return {angle_in(arc_, past < 0.5 * (arc_.width + two_pi) ? past : 0),
          sample_height(is_main ? ribbon_.main_law() : HeightLaw::logistic, u_height, line(from.mode, to.mode),
                        line(from.scale_below, to.scale_below), line(from.scale_above, to.scale_above))};
}

RestrictedRow::RestrictedRow(const RibbonRow& row, const Arc& arc)
    : parts_(row.parts()),
      ribbon_{RestrictedRibbon(row.ribbon(0), arc), RestrictedRibbon(row.ribbon(1), arc),
              RestrictedRibbon(row.ribbon(2), arc), RestrictedRibbon(row.ribbon(3), arc)} {
  std::ranges::copy(row.masses(), mass_.begin());
}

}  // namespace tress::inline v0_2::adaptive
