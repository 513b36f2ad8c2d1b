#include "fit/fit_ribbons.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "base/pi.h"
#include "fit/exit_sums.h"
#include "fit/ribbon_lanes.h"
#include "fit/ribbon_tilt.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr std::size_t main_knots = Ribbon::main_knots, broad_knots = Ribbon::broad_knots;
constexpr std::size_t parts = RowExits::most_parts;
constexpr std::uint32_t bins = RowExits::bins, bins_per_broad = bins / broad_knots;
constexpr double quantile_share = 0.3;        // share of the knots that follow the light; the rest are even
constexpr float logistic_over_normal = 0.6f;  // ratio of the scales of laws that look alike
constexpr float least_broad_scale = 0.1f;
// The scales of the normal and of the logistic law at the start, over the width of the light.
constexpr float normal_scale = 0.7f;
constexpr std::array<float, 2> main_scales{normal_scale, 0.4f};

class Fitter {
 public:
  Fitter(const RowExits& exits, const PartParents& parents, const RibbonFitRule& rule)
      : exits_(exits), parents_(parents), rule_(rule) {
    lanes_.main.least_scale = Ribbon::least_scale;
    lanes_.broad.least_scale = least_broad_scale;
    for (std::size_t p = 0; p < parts; ++p) place_knots(p);
    set_widths(lanes_.main);
    set_widths(lanes_.broad);
    place_harmonics(lanes_, harmonics_);
  }

  FittedRibbons fit() {
    if (rule_.thin_rounds == 0) {
      start(exits_);
    } else {
      const RowExits thin = thin_exits(exits_);
      start(thin);
      move(thin, rule_.thin_rounds);
      for (std::size_t p = 0; p < parts; ++p) {
        if (has_light(p)) keep_only(likeliest(thin, p), p);
      }
      cut_pieces(exits_);
    }
    move(exits_, rule_.rounds);
    match_directions(lanes_, harmonics_, wanted_directions());
    FittedRibbons fitted;
    for (std::size_t p = 0; p < parts; ++p) {
      if (has_light(p)) fitted.ribbon[p] = ribbon_of(likeliest(exits_, p));
    }
    return fitted;
  }

 private:
  bool has_light(std::size_t p) const { return exits_.part[p].count > 0; }
  bool starts_from_parent(std::size_t p) const { return rule_.from_parent && parents_[p] != nullptr; }

  /// The lane of the likeliest of the laws of a part that has light.
  std::size_t likeliest(const RowExits& exits, std::size_t p) const {
    const std::size_t other = p + parts;
    if (!lanes_.active[other]) return p;
    if (!lanes_.active[p]) return other;
    return log_likelihood(exits, lanes_, other) > log_likelihood(exits, lanes_, p) ? other : p;
  }
  void keep_only(std::size_t kept, std::size_t p) {
    for (std::size_t lane = p; lane < fit_lanes; lane += parts) lanes_.active[lane] = lane == kept;
  }

  void move(const RowExits& exits, int rounds) {
    for (int i = 0; i < rounds; ++i) {
      RowSums sums;
      add_exits(exits, lanes_, sums);
      move_layers(lanes_, sums, rule_.prior);
    }
  }

  void place_knots(std::size_t p) {
    const RowExits::Part& part = exits_.part[p];
    std::array<double, bins + 1> below;
    below[0] = 0;
    const double per_weight = has_light(p) ? quantile_share / part.count : 0;
    for (std::uint32_t bin = 0; bin < bins; ++bin) {
      float light = 0;
      if (has_light(p)) {
        for (std::uint32_t i = part.begin[bin]; i < part.begin[bin + 1]; ++i) light += exits_.w[i];
      }
      below[bin + 1] = below[bin] + per_weight * static_cast<double>(light) + (1 - quantile_share) / bins;
    }
    auto& place = lanes_.main.bin[p];
    std::uint32_t bin = 0;
    for (std::size_t k = 0; k < main_knots; ++k) {
      const double share = (static_cast<double>(k) + 0.5) / main_knots * below.back();
      const std::uint32_t least = k > 0 ? place[k - 1] + 1 : 0;
      const std::uint32_t most = bins - static_cast<std::uint32_t>(main_knots - k);
      while (bin < bins && below[bin + 1] < share) ++bin;
      place[k] = std::clamp(bin, least, most);
    }
    for (std::uint32_t k = 0; k < broad_knots; ++k) lanes_.broad.bin[p][k] = k * bins_per_broad;
  }

  /// Cuts these exits at the knots.
  void cut_pieces(const RowExits& exits) {
    for (std::size_t p = 0; p < parts; ++p) cut_pieces(exits.part[p], p);
    for (std::size_t lane = 0; lane < fit_lanes; ++lane) {
      const RowExits::Part& part = exits.part[part_of_lane(lane)];
      lanes_.count[lane] = part.count > 0 ? static_cast<float>(part.count) : 1.0f;
    }
  }

  void cut_pieces(const RowExits::Part& part, std::size_t p) {
    const auto& place = lanes_.main.bin[p];
    const auto& begin = part.begin;
    std::size_t& count = lanes_.piece_count[p];
    count = 0;
    if (!has_light(p)) return;
    std::uint32_t main = main_knots - 1, next = 0;
    for (std::uint32_t bin = 0; bin < bins;) {
      const bool before_first = next == 0 && place[0] > bin;
      if (next < main_knots && place[next] == bin) main = next++;
      const std::uint32_t broad = bin / bins_per_broad;
      std::uint32_t end = (broad + 1) * bins_per_broad;
      if (next < main_knots) end = std::min(end, place[next]);
      if (begin[end] > begin[bin]) {
        const std::uint32_t after = main + 1 < main_knots ? place[main + 1] : place[0] + bins;
        const double width = two_pi / bins * (after - place[main]);
        lanes_.pieces[p][count++] = {begin[bin],
                                     begin[end],
                                     main,
                                     broad,
                                     static_cast<float>(RowExits::azimuth(place[main]) - (before_first ? two_pi : 0)),
                                     static_cast<float>(1 / width),
                                     static_cast<float>(RowExits::azimuth(broad * bins_per_broad)),
                                     static_cast<float>(broad_knots / two_pi)};
      }
      bin = end;
    }
  }

  template <std::size_t count>
  static void set_widths(LayerLanes<count>& layer) {
    for (std::size_t lane = 0; lane < fit_lanes; ++lane) {
      const auto& bin = layer.bin[part_of_lane(lane)];
      for (std::size_t k = 0; k < count; ++k) {
        const std::uint32_t width = k + 1 < count ? bin[k + 1] - bin[k] : bin[0] + bins - bin[k];
        layer.knots[k].width[lane] = static_cast<float>(two_pi / bins * width);
      }
      for (std::size_t k = 0; k < count; ++k) {
        layer.knots[k].hat[lane] = 0.5f * (layer.knots[k].width[lane] + layer.knots[layer.before(k)].width[lane]);
      }
    }
  }

  void start(const RowExits& exits) {
    cut_pieces(exits);
    for (std::size_t p = 0; p < parts; ++p) start(exits, p);
    scale_to_one(lanes_);
    if (rule_.from_parent) set_prior();
  }

  void start(const RowExits& exits, std::size_t p) {
    const bool one_law = parents_[p] != nullptr && rule_.parents_law;
    for (std::size_t lane = p; lane < fit_lanes; lane += parts) {
      lanes_.law[lane] = one_law ? parents_[p]->main_law() : lane < parts ? HeightLaw::normal : HeightLaw::logistic;
      lanes_.active[lane] = has_light(p) && (lane < parts || !one_law);
    }
    if (starts_from_parent(p)) {
      start_from(lanes_.main, parents_[p]->main(), p, 1e-4f);
      start_from(lanes_.broad, parents_[p]->broad(), p, 1e-5f);
      if (!one_law) widen(p, parents_[p]->main_law());
      return;
    }
    PartHeights sums;
    add_heights(exits, lanes_, p, sums);
    start_main(sums.main, p, 1);
    FarHeights far;
    for (const float widths : {2.0f, 2.5f}) {  // the main layer becomes narrower each time
      auto near = sums.main;
      far = {};
      split_heights(exits, p, widths, near, far);
      for (std::size_t lane = p; lane < fit_lanes; lane += parts) start_main(near, lane, 1);
    }
    // With one law the broad layer starts at the height of a second peak. With the other it starts about the main
    // layer, from where it would fill the valley between two peaks. The likelier fit is kept.
    const auto* peak = far.farther_side(lanes_.count[p]);
    for (std::size_t lane = p; lane < fit_lanes; lane += parts) {
      if (lane != p && peak != nullptr) {
        start_layer(lanes_.broad, *peak, lane, 1, 0.5f);
      } else {
        start_main(sums.main, lane, 1 - rule_.first_broad_share);
        start_layer(lanes_.broad, sums.broad, lane, rule_.first_broad_share, 0.7f);
      }
    }
  }

  /// The light far from the mean height of its azimuth, below and above it.
  struct FarHeights {
    std::array<HeightSums, broad_knots> below{}, above{};
    float excess_below = 0, excess_above = 0;  ///< light times the widths by which it is too far for the main layer

    /// The side whose light is farther away, counted by its distance; null if it has next to none. A second peak is
    /// farther away than the tail of the main layer.
    const std::array<HeightSums, broad_knots>* farther_side(float exits) const {
      constexpr float least_share = 0.003f;
      const auto& side = excess_below > excess_above ? below : above;
      return light_of(side) < least_share * exits ? nullptr : &side;
    }
    static float light_of(const std::array<HeightSums, broad_knots>& sums) {
      float light = 0;
      for (const HeightSums& sum : sums) light += sum.light;
      return light;
    }
  };

  /// Moves the light that is this many widths from the main layer, as it is now, out of the sums of that layer.
  void split_heights(const RowExits& exits, std::size_t p, float widths, std::array<HeightSums, main_knots>& near,
                     FarHeights& far) const {
    const auto add = [](HeightSums& to, float w, float s, float t) {
      to.light += w;
      to.light_s += w * s;
      to.height += w * t;
      to.height_s += w * t * s;
      to.square += w * t * t;
      to.square_s += w * t * t * s;
    };
    for (std::size_t i = 0; i < lanes_.piece_count[p]; ++i) {
      const RibbonPiece& piece = lanes_.pieces[p][i];
      const KnotLanes &here = lanes_.main.knots[piece.main], &there = lanes_.main.knots[MainLanes::after(piece.main)];
      for (std::size_t exit = piece.begin; exit < piece.end; ++exit) {
        const float x = exits.x[exit], t = exits.t[exit], w = exits.w[exit];
        const float s = (x - piece.main_x0) * piece.main_inverse_width;
        const auto line = [s, p](const Lanes& a, const Lanes& b) { return a[p] + s * (b[p] - a[p]); };
        const float away = t - line(here.mode, there.mode), scale = line(here.scale_below, there.scale_below);
        if (std::abs(away) <= widths / normal_scale * scale) continue;
        add(near[piece.main], -w, s, t);
        (away < 0 ? far.excess_below : far.excess_above) += w * (std::abs(away) / (scale / normal_scale) - widths);
        add((away < 0 ? far.below : far.above)[piece.broad], w, (x - piece.broad_x0) * piece.broad_inverse_width, t);
      }
    }
  }

  static void set_scales(KnotLanes& knot, std::size_t lane, float below, float above, float least) {
    knot.scale_below[lane] = std::clamp(below, least, Ribbon::largest_scale);
    knot.scale_above[lane] = std::clamp(above, least, Ribbon::largest_scale);
    knot.log_below[lane] = std::log(knot.scale_below[lane]);
    knot.log_above[lane] = std::log(knot.scale_above[lane]);
  }

  void start_main(const std::array<HeightSums, main_knots>& sums, std::size_t lane, float share) {
    start_layer(lanes_.main, sums, lane, share, main_scales[lanes_.law[lane] == HeightLaw::normal ? 0 : 1]);
  }

  /// Starts from the masses, means and widths of the light of each hat. narrower: the ratio of a scale to a width.
  template <std::size_t count>
  void start_layer(LayerLanes<count>& layer, const std::array<HeightSums, count>& sums, std::size_t lane, float share,
                   float narrower) {
    constexpr float added = 1;  // in exits of the mean of all
    const float n = lanes_.count[lane];
    float all = 1e-6f, all_t = 0, all_tt = 0;
    for (const HeightSums& sum : sums) {
      all += sum.light;
      all_t += sum.height;
      all_tt += sum.square;
    }
    for (std::size_t k = 0; k < count; ++k) {
      const HeightSums &from = sums[k], &to = sums[layer.before(k)];
      const float light = from.light - from.light_s + to.light_s;
      const float exits = light + added;
      const float middle = (from.height - from.height_s + to.height_s + added * all_t / all) / exits;
      const float square = (from.square - from.square_s + to.square_s + added * all_tt / all) / exits;
      const float scale = std::sqrt(std::max(square - middle * middle, 0.0f)) * narrower;
      KnotLanes& knot = layer.knots[k];
      knot.mode[lane] = std::clamp(middle, -Ribbon::largest_mode, Ribbon::largest_mode);
      set_scales(knot, lane, scale, scale, layer.least_scale);
      knot.density[lane] = share * (light + added / count * 0.1f) / (n + 0.1f * added) / knot.hat[lane];
    }
  }

  /// Starts from the parent's knots, interpolated linearly.
  template <std::size_t count>
  static void start_from(LayerLanes<count>& layer, std::span<const RibbonKnot> knots, std::size_t p, float least) {
    constexpr auto turn = static_cast<float>(two_pi);
    std::size_t next = 0;
    for (std::size_t k = 0; k < count; ++k) {
      const auto x = static_cast<float>(RowExits::azimuth(layer.bin[p][k]));
      while (next < knots.size() && knots[next].azimuth <= x) ++next;
      const RibbonKnot &a = knots[next == 0 ? knots.size() - 1 : next - 1], &b = knots[next == knots.size() ? 0 : next];
      const float from = a.azimuth - (next == 0 ? turn : 0), to = b.azimuth + (next == knots.size() ? turn : 0);
      const float s = to > from ? std::clamp((x - from) / (to - from), 0.0f, 1.0f) : 0;
      const auto line = [s](float here, float there) { return here + s * (there - here); };
      for (std::size_t lane = p; lane < fit_lanes; lane += parts) {
        KnotLanes& knot = layer.knots[k];
        knot.density[lane] = std::max(line(a.density, b.density), least);
        knot.mode[lane] = line(a.mode, b.mode);
        set_scales(knot, lane, line(a.scale_below, b.scale_below), line(a.scale_above, b.scale_above),
                   layer.least_scale);
      }
    }
  }

  /// Converts the scales to the law that the parent does not have.
  void widen(std::size_t p, HeightLaw law) {
    for (std::size_t lane = p; lane < fit_lanes; lane += parts) {
      if (lanes_.law[lane] == law) continue;
      const float by = law == HeightLaw::normal ? logistic_over_normal : 1 / logistic_over_normal;
      for (KnotLanes& knot : lanes_.main.knots) {
        set_scales(knot, lane, knot.scale_below[lane] * by, knot.scale_above[lane] * by, lanes_.main.least_scale);
      }
    }
  }

  void set_prior() {
    parents_directions_ = mean_directions(lanes_, harmonics_);
    const auto set = [this](KnotLanes& knot) {
      knot.prior_mode = knot.mode;
      knot.prior_log_below = knot.log_below;
      knot.prior_log_above = knot.log_above;
      for (std::size_t lane = 0; lane < fit_lanes; ++lane) {
        const bool has_parent = parents_[part_of_lane(lane)] != nullptr;
        knot.prior_light[lane] = has_parent ? rule_.kappa * knot.density[lane] * knot.hat[lane] : 0;
      }
    };
    for (KnotLanes& knot : lanes_.main.knots) set(knot);
    for (KnotLanes& knot : lanes_.broad.knots) set(knot);
  }

  /// The mean directions of the exits, together with the exits that the parent counts for.
  MeanDirections wanted_directions() const {
    MeanDirections wanted;
    for (std::size_t lane = 0; lane < fit_lanes; ++lane) {
      const std::size_t p = part_of_lane(lane);
      const double own = exits_.part[p].count, more = starts_from_parent(p) ? double{rule_.kappa} : 0;
      for (std::size_t j = 0; j < wanted.size(); ++j) {
        const double parents = more > 0 ? more * parents_directions_[j][lane] : 0;
        wanted[j][lane] = own > 0 ? (own * exits_.part[p].directions[j] + parents) / (own + more) : 0;
      }
    }
    return wanted;
  }

  Ribbon ribbon_of(std::size_t lane) {
    const RowExits::Part& part = exits_.part[part_of_lane(lane)];
    LaneDecays decays;
    add_decays(exits_, lanes_, lane, decays);
    const std::array<double, 2> mean{part.left[0] / part.light, part.left[1] / part.light};
    std::array<RibbonKnot, main_knots> main;
    std::array<RibbonKnot, broad_knots> broad;
    const auto write = [&](const auto& layer, const auto& sums, auto& knots) {
      constexpr double prior = 2;  // in exits of the mean of all
      for (std::size_t k = 0; k < knots.size(); ++k) {
        const KnotLanes& knot = layer.knots[k];
        const DecaySums &here = sums[k], &before = sums[layer.before(k)];
        const auto left = [&](float sum, float by_s, float before_by_s, double of_all) {
          const double light = static_cast<double>(here.clear - here.clear_s + before.clear_s);
          const double kept = static_cast<double>(sum - by_s + before_by_s);
          return static_cast<float>(std::clamp((kept + prior * of_all) / (light + prior), 0.0, 1.0));
        };
        knots[k] = {static_cast<float>(RowExits::azimuth(layer.bin[part_of_lane(lane)][k])),
                    knot.density[lane],
                    knot.mode[lane],
                    knot.scale_below[lane],
                    knot.scale_above[lane],
                    {left(here.first, here.first_s, before.first_s, mean[0]),
                     left(here.second, here.second_s, before.second_s, mean[1])}};
      }
    };
    write(lanes_.main, decays.main, main);
    write(lanes_.broad, decays.broad, broad);
    return Ribbon(main, lanes_.law[lane], broad);
  }

  const RowExits& exits_;
  const PartParents& parents_;
  RibbonFitRule rule_;
  RibbonLanes lanes_;
  RowHarmonics harmonics_;
  MeanDirections parents_directions_{};
};

}  // namespace

FittedRibbons fit_ribbons(const RowExits& exits, const PartParents& parents, const RibbonFitRule& rule) {
  return Fitter(exits, parents, rule).fit();
}

}  // namespace tress::inline v0_2::adaptive
