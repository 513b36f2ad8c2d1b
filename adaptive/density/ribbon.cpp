#include "tress/adaptive/ribbon.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "base/normal_quantile.h"
#include "base/pi.h"
#include "density/invert_line.h"
#include "density/unit.h"
#include "tress/adaptive/mixture.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr float below_one = 0.99999994f;
constexpr float least_share = 0x1p-25f;  // of the mass of a side; no height is drawn beyond it

/// A layer's values at an azimuth between two knots.
struct Between {
  float density, mode, scale_below, scale_above;
};

struct Layer {
  std::span<const RibbonKnot> knots;
  std::span<const float> below;

  const RibbonKnot& after(std::size_t k) const { return knots[k + 1 < knots.size() ? k + 1 : 0]; }
  float width(std::size_t k) const {
    return k + 1 < knots.size() ? knots[k + 1].azimuth - knots[k].azimuth
                                : knots[0].azimuth + two_pi_f - knots[k].azimuth;
  }
  /// The segment that contains x in [-pi, pi), and the fraction of it before x.
  std::pair<std::size_t, float> find(float x) const {
    const auto above = std::upper_bound(knots.begin(), knots.end(), x,
                                        [](float at, const RibbonKnot& knot) { return at < knot.azimuth; });
    const std::size_t k =
        above == knots.begin() ? knots.size() - 1 : static_cast<std::size_t>(above - knots.begin()) - 1;
    const float from = x - knots[k].azimuth + (above == knots.begin() ? two_pi_f : 0), all = width(k);
    return {k, all > 0 ? std::clamp(from / all, 0.0f, 1.0f) : 0};
  }
  Between at(std::size_t k, float s) const {
    const RibbonKnot &a = knots[k], &b = after(k);
    const auto line = [s](float from, float to) { return from + s * (to - from); };
    return {line(a.density, b.density), line(a.mode, b.mode), line(a.scale_below, b.scale_below),
            line(a.scale_above, b.scale_above)};
  }
  Between at(float x) const {
    const auto [k, s] = find(x);
    return at(k, s);
  }
  /// The mass from the first knot to x.
  float from_first(std::size_t k, float s) const {
    const float a = knots[k].density, b = after(k).density;
    return below[k] + width(k) * s * (a + 0.5f * s * (b - a));
  }
  /// The mass from -pi to x.
  float below_azimuth(float x) const {
    const auto [k, s] = find(x);
    const float to = from_first(k, s);
    if (!(knots[0].azimuth > -pi_f)) return to;
    const auto [last, at_cut] = find(-pi_f);
    const float cut = from_first(last, at_cut);
    return x < knots[0].azimuth ? to - cut : to + (below.back() - cut);
  }
  /// The azimuth that has the share u of the layer's mass before it, and the values there.
  std::pair<float, Between> sample(float u) const {
    const float v = u * below.back();
    const auto above = std::upper_bound(below.begin() + 1, below.end() - 1, v);
    const std::size_t k = static_cast<std::size_t>(above - below.begin()) - 1;
    const float mass = below[k + 1] - below[k];
    const float r = mass > 0 ? std::clamp((v - below[k]) / mass, 0.0f, below_one) : 0.5f;
    const float s = invert_line(knots[k].density, after(k).density, r);
    return {wrap_angle(knots[k].azimuth + s * width(k)), at(k, s)};
  }
};

template <std::size_t count>
double add_up(const std::array<RibbonKnot, count>& knots, std::array<double, count + 1>& below) {
  below[0] = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const RibbonKnot& next = knots[(k + 1) % count];
    const double turn = k + 1 < count ? 0 : two_pi;
    const double width = static_cast<double>(next.azimuth) + turn - static_cast<double>(knots[k].azimuth);
    below[k + 1] = below[k] + 0.5 * std::max(width, 0.0) *
                                  (static_cast<double>(knots[k].density) + static_cast<double>(next.density));
  }
  return below[count];
}

template <std::size_t count>
void scale(std::array<RibbonKnot, count>& knots, const std::array<double, count + 1>& from, double factor,
           std::array<float, count + 1>& below) {
  for (RibbonKnot& knot : knots) knot.density = static_cast<float>(static_cast<double>(knot.density) * factor);
  for (std::size_t k = 0; k <= count; ++k) below[k] = static_cast<float>(from[k] * factor);
}

template <std::size_t count>
void set_level(std::array<RibbonKnot, count>& knots, float density, std::array<float, count + 1>& below) {
  for (std::size_t k = 0; k < count; ++k) {
    const float turns = static_cast<float>(k) / static_cast<float>(count);
    knots[k] = {-pi_f + two_pi_f * turns, density, 0, 0.5f, 0.5f, {1, 1}};
    below[k] = turns * two_pi_f * density;
  }
  below[count] = two_pi_f * density;
}

}  // namespace

float height_density(HeightLaw law, float t, float mode, float scale_below, float scale_above) {
  if (!std::isfinite(t)) return 0;
  const float z = std::abs(t - mode) / (t < mode ? scale_below : scale_above), both = scale_below + scale_above;
  if (law == HeightLaw::normal) return 0.797884561f / both * std::exp(-0.5f * z * z);
  const float e = std::exp(-z);
  return 2 * e / (both * (1 + e) * (1 + e));
}

float height_share_below(HeightLaw law, float t, float mode, float scale_below, float scale_above) {
  if (std::isnan(t)) t = 0;
  const bool is_below = t < mode;
  const float z = std::abs(t - mode) / (is_below ? scale_below : scale_above);
  const float e = law == HeightLaw::logistic ? std::exp(-z) : 0;
  const float beyond = law == HeightLaw::logistic ? 2 * e / (1 + e) : std::erfc(z / std::numbers::sqrt2_v<float>);
  const float both = scale_below + scale_above;
  return is_below ? beyond * (scale_below / both) : 1 - beyond * (scale_above / both);
}

float sample_height(HeightLaw law, float u, float mode, float scale_below, float scale_above) {
  u = unit(u);
  const float both = scale_below + scale_above;
  const bool is_below = u * both < scale_below;
  const float side = is_below ? scale_below : scale_above;
  const float beyond = std::clamp((is_below ? u : 1 - u) * both / side, least_share, 1.0f);
  const float z = law == HeightLaw::logistic ? std::log((2 - beyond) / beyond)
                                             : normal_beyond(1 - beyond, -std::log(beyond * (2 - beyond)));
  return mode + (is_below ? -z : z) * side;
}

Ribbon::Ribbon(Uniform) { set_uniform(); }

Ribbon::Ribbon() {
  static const Ribbon uniform{Uniform()};
  *this = uniform;
}

void Ribbon::set_uniform() {
  main_law_ = HeightLaw::logistic;
  set_level(main_, 1 / two_pi_f, main_below_);
  set_level(broad_, 0, broad_below_);
}

Ribbon::Ribbon(std::span<const RibbonKnot, main_knots> main, HeightLaw main_law,
               std::span<const RibbonKnot, broad_knots> broad)
    : main_law_(main_law) {
  std::copy(main.begin(), main.end(), main_.begin());
  std::copy(broad.begin(), broad.end(), broad_.begin());
  std::array<double, main_knots + 1> main_below;
  std::array<double, broad_knots + 1> broad_below;
  const double mass = add_up(main_, main_below) + add_up(broad_, broad_below);
  if (!(mass > 0)) {
    set_uniform();
    return;
  }
  scale(main_, main_below, 1 / mass, main_below_);
  scale(broad_, broad_below, 1 / mass, broad_below_);
}

float Ribbon::density(float x, float t) const {
  x = wrap_angle(x);
  const Between main = Layer{main_, main_below_}.at(x), broad = Layer{broad_, broad_below_}.at(x);
  return main.density * height_density(main_law_, t, main.mode, main.scale_below, main.scale_above) +
         broad.density * height_density(HeightLaw::logistic, t, broad.mode, broad.scale_below, broad.scale_above);
}

std::array<float, 2> Ribbon::cdf(float x, float t) const {
  x = wrap_angle(x);
  const Layer main_layer{main_, main_below_}, broad_layer{broad_, broad_below_};
  const Between main = main_layer.at(x), broad = broad_layer.at(x);
  const float all = main.density + broad.density;
  const float share_below =
      main.density * height_share_below(main_law_, t, main.mode, main.scale_below, main.scale_above) +
      broad.density * height_share_below(HeightLaw::logistic, t, broad.mode, broad.scale_below, broad.scale_above);
  return {std::clamp(main_layer.below_azimuth(x) + broad_layer.below_azimuth(x), 0.0f, 1.0f),
          all > 0 ? std::clamp(share_below / all, 0.0f, 1.0f) : 0.5f};
}

Ribbon::Place Ribbon::sample(float u_azimuth, float u_height) const {
  const float in_main = main_mass(), in_broad = broad_below_.back();
  const float v = unit(u_azimuth) * (in_main + in_broad);
  const bool from_main = v < in_main || !(in_broad > 0);
  const auto [x, at] = from_main ? Layer{main_, main_below_}.sample(std::min(v / in_main, below_one))
                                 : Layer{broad_, broad_below_}.sample(std::min((v - in_main) / in_broad, below_one));
  return {
      x, sample_height(from_main ? main_law_ : HeightLaw::logistic, u_height, at.mode, at.scale_below, at.scale_above)};
}

}  // namespace tress::inline v0_2::adaptive
