#include "fit/fit_ribbon.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "fit/ribbon_decays.h"
#include "fit/ribbon_kernels.h"
#include "fit/ribbon_layer.h"
#include "fit/ribbon_moments.h"
#include "fit/ribbon_step.h"

namespace tress::adaptive {
namespace {

constexpr double pi = std::numbers::pi;
constexpr std::size_t main_knots = Ribbon::main_knots, broad_knots = Ribbon::broad_knots;
constexpr double quantile_share = 0.3;  // of the knots' places, the rest being spread evenly
constexpr double first_broad_share = 0.2;
constexpr double logistic_over_normal = 0.6;  // the scales of laws that look alike
constexpr double least_broad_scale = 0.1;

class Fitter {
 public:
  Fitter(const ExitColumns& exits, bool decays, const RibbonFitRule& rule)
      : decays_(decays), rule_(rule), light_{exits, 1, {}, {}, {}} {
    double sum = 0, squares = 0;
    for (std::size_t i = 0; i < exits.size(); ++i) {
      sum += static_cast<double>(exits.w[i]);
      squares += static_cast<double>(exits.w[i]) * static_cast<double>(exits.w[i]);
    }
    light_.count = squares > 0 ? sum * sum / squares : 1;
    const double scale = sum > 0 ? light_.count / sum : 0;
    light_.weights.resize(exits.w.size(), 0.0f);
    for (std::size_t i = 0; i < exits.size(); ++i) {
      light_.weights[i] = static_cast<float>(scale * static_cast<double>(exits.w[i]));
    }
    light_.harmonics = mean_harmonics(light_);
    place_knots();
    cut_pieces();
  }

  RibbonFit fit(const Ribbon* earlier) {
    std::optional<RibbonFit> best;
    for (const HeightLaw law : {HeightLaw::normal, HeightLaw::logistic}) {
      if (rule_.keep_law && earlier != nullptr && law != earlier->main_law()) continue;
      law_ = law;
      if (earlier != nullptr) {
        start(*earlier);
      } else {
        start();
      }
      const int rounds = earlier != nullptr ? rule_.rounds : rule_.first_rounds;
      for (int i = 0; i < rounds; ++i) round();
      match_moments(light_, main_, broad_);
      RibbonFit fit = result();
      if (!best || fit.log_likelihood > best->log_likelihood) best = fit;
    }
    return *best;
  }

 private:
  void place_knots() {
    std::vector<double> below(ExitColumns::bins + 1, 0.0);
    for (std::uint32_t bin = 0; bin < ExitColumns::bins; ++bin) {
      double light = 0;
      for (std::uint32_t i = light_.exits.begin[bin]; i < light_.exits.begin[bin + 1]; ++i)
        light += static_cast<double>(light_.weights[i]);
      below[bin + 1] = below[bin] + quantile_share * light / light_.count + (1 - quantile_share) / ExitColumns::bins;
    }
    std::uint32_t bin = 0;
    for (std::size_t k = 0; k < main_knots; ++k) {
      const double share = (static_cast<double>(k) + 0.5) / main_knots * below.back();
      const std::uint32_t least = k > 0 ? main_.bin[k - 1] + 1 : 0;
      const std::uint32_t most = ExitColumns::bins - static_cast<std::uint32_t>(main_knots - k);
      while (bin < ExitColumns::bins && below[bin + 1] < share) ++bin;
      main_.bin[k] = std::clamp(bin, least, most);
    }
    for (std::size_t k = 0; k < broad_knots; ++k) {
      broad_.bin[k] = static_cast<std::uint32_t>(k * (ExitColumns::bins / broad_knots));
    }
    broad_.least_scale = least_broad_scale;
  }

  void cut_pieces() {
    std::size_t main = main_knots - 1, next = 0, broad = 0;
    bool before_first = true;
    for (std::uint32_t bin = 0; bin < ExitColumns::bins;) {
      if (next < main_knots && main_.bin[next] == bin) {
        main = next++;
        before_first = false;
      }
      broad = bin / (ExitColumns::bins / broad_knots);
      std::uint32_t end = static_cast<std::uint32_t>((broad + 1) * (ExitColumns::bins / broad_knots));
      if (next < main_knots) end = std::min(end, main_.bin[next]);
      if (light_.exits.begin[end] > light_.exits.begin[bin]) {
        light_.pieces.push_back({light_.exits.begin[bin], light_.exits.begin[end], main, broad, before_first});
      }
      bin = end;
    }
  }

  RibbonExits exits_of(const RibbonPiece& piece) const {
    return {light_.exits.x.data() + piece.begin, light_.exits.t.data() + piece.begin,
            light_.weights.data() + piece.begin, piece.end - piece.begin};
  }

  /// Masses, means and widths of the light of each hat.
  template <std::size_t count>
  void start_layer(RibbonLayer<count>& layer, std::size_t RibbonPiece::* segment, double share, double narrower) {
    std::array<double, count> w{}, wt{}, wtt{};
    double all_t = 0, all_tt = 0;
    for (const RibbonPiece& piece : light_.pieces) {
      const std::size_t k = piece.*segment, next = layer.after(k);
      const RibbonSegment s = layer.segment(k, count == main_knots && piece.before_first);
      for (std::uint32_t i = piece.begin; i < piece.end; ++i) {
        const double at = static_cast<double>((light_.exits.x[i] - s.x0) * s.inverse_width);
        const double weight = static_cast<double>(light_.weights[i]), t = static_cast<double>(light_.exits.t[i]);
        w[k] += (1 - at) * weight, wt[k] += (1 - at) * weight * t, wtt[k] += (1 - at) * weight * t * t;
        w[next] += at * weight, wt[next] += at * weight * t, wtt[next] += at * weight * t * t;
        all_t += weight * t;
        all_tt += weight * t * t;
      }
    }
    constexpr double added = 1;  // exits of the mean of all
    const double mean = all_t / light_.count, square = all_tt / light_.count;
    for (std::size_t k = 0; k < count; ++k) {
      const double n = w[k] + added, middle = (wt[k] + added * mean) / n;
      const double variance = std::max((wtt[k] + added * square) / n - middle * middle, 0.0);
      layer.mode[k] = std::clamp(middle, -double{Ribbon::largest_mode}, double{Ribbon::largest_mode});
      layer.scale_below[k] = layer.scale_above[k] =
          std::clamp(narrower * std::sqrt(variance), layer.least_scale, double{Ribbon::largest_scale});
      layer.density[k] = share * (w[k] + added / count * 0.1) / (light_.count + 0.1 * added) / layer.hat(k);
    }
  }

  void start() {
    const double of_normal = 0.7, of_logistic = 0.4;
    start_layer(main_, &RibbonPiece::main, 1 - first_broad_share, law_ == HeightLaw::normal ? of_normal : of_logistic);
    start_layer(broad_, &RibbonPiece::broad, first_broad_share, 0.7);
  }

  template <std::size_t count>
  static void start_from(RibbonLayer<count>& layer, std::span<const RibbonKnot> knots) {
    for (std::size_t k = 0; k < count; ++k) {
      const double x = layer.azimuth(k);
      std::size_t next = 0;
      while (next < knots.size() && static_cast<double>(knots[next].azimuth) <= x) ++next;
      const RibbonKnot &a = knots[next == 0 ? knots.size() - 1 : next - 1], &b = knots[next == knots.size() ? 0 : next];
      const double from = static_cast<double>(a.azimuth) - (next == 0 ? 2 * pi : 0);
      const double to = static_cast<double>(b.azimuth) + (next == knots.size() ? 2 * pi : 0);
      const double s = to > from ? std::clamp((x - from) / (to - from), 0.0, 1.0) : 0;
      const auto line = [s](float p, float q) { return (1 - s) * static_cast<double>(p) + s * static_cast<double>(q); };
      layer.density[k] = line(a.density, b.density);
      layer.mode[k] = line(a.mode, b.mode);
      layer.scale_below[k] = std::max(line(a.scale_below, b.scale_below), layer.least_scale);
      layer.scale_above[k] = std::max(line(a.scale_above, b.scale_above), layer.least_scale);
    }
  }

  void start(const Ribbon& earlier) {
    start_from(main_, earlier.main());
    start_from(broad_, earlier.broad());
    if (law_ != earlier.main_law()) widen(law_ == HeightLaw::normal ? 1 / logistic_over_normal : logistic_over_normal);
    for (double& density : main_.density) density = std::max(density, 1e-4);
    for (double& density : broad_.density) density = std::max(density, 1e-5);
    scale_to_one(main_, broad_);
  }

  void widen(double by) {
    for (std::size_t k = 0; k < main_knots; ++k) {
      for (double* scale : {&main_.scale_below[k], &main_.scale_above[k]}) {
        *scale = std::clamp(*scale * by, main_.least_scale, double{Ribbon::largest_scale});
      }
    }
  }

  void round() {
    std::array<SegmentSums, main_knots> main_sums{};
    std::array<SegmentSums, broad_knots> broad_sums{};
    for (const RibbonPiece& piece : light_.pieces) {
      add_exits(main_.segment(piece.main, piece.before_first), law_, broad_.segment(piece.broad, false),
                exits_of(piece), main_sums[piece.main], broad_sums[piece.broad]);
    }
    move_layer(main_, law_, main_sums, light_.count, rule_);
    move_layer(broad_, HeightLaw::logistic, broad_sums, light_.count, rule_);
    scale_to_one(main_, broad_);
  }

  RibbonFit result() const {
    std::array<RibbonKnot, main_knots> main;
    std::array<RibbonKnot, broad_knots> broad;
    const auto write = [](const auto& layer, auto& knots) {
      for (std::size_t k = 0; k < knots.size(); ++k) {
        knots[k] = {static_cast<float>(layer.azimuth(k)),     static_cast<float>(layer.density[k]),
                    static_cast<float>(layer.mode[k]),        static_cast<float>(layer.scale_below[k]),
                    static_cast<float>(layer.scale_above[k]), {1, 1}};
      }
    };
    write(main_, main);
    write(broad_, broad);
    std::vector<float> density(light_.exits.x.size()), main_share(light_.exits.x.size());
    double likelihood = 0;
    for (const RibbonPiece& piece : light_.pieces) {
      evaluate_exits(main_.segment(piece.main, piece.before_first), law_, broad_.segment(piece.broad, false),
                     exits_of(piece), density.data() + piece.begin, main_share.data() + piece.begin);
    }
    for (std::size_t i = 0; i < light_.exits.size(); ++i) {
      likelihood += static_cast<double>(light_.weights[i]) * static_cast<double>(std::log(density[i]));
    }
    if (decays_) write_decays(light_, main_, broad_, main_share, main, broad);
    return {Ribbon(main, law_, broad), likelihood / light_.count};
  }

  bool decays_;
  RibbonFitRule rule_;
  RibbonLight light_;
  HeightLaw law_ = HeightLaw::logistic;
  MainLayer main_;
  BroadLayer broad_;
};

}  // namespace

RibbonFit fit_ribbon(const ExitColumns& exits, const Ribbon* earlier, bool decays, const RibbonFitRule& rule) {
  return Fitter(exits, decays, rule).fit(earlier);
}

}  // namespace tress::adaptive
