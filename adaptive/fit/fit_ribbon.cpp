#include "fit/fit_ribbon.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "fit/ribbon_kernels.h"

namespace tress::adaptive {
namespace {

constexpr double pi = std::numbers::pi;
constexpr std::size_t main_knots = Ribbon::main_knots, broad_knots = Ribbon::broad_knots;
constexpr double quantile_share = 0.3;  // of the knots' places, the rest being spread evenly
constexpr double first_broad_share = 0.2;
constexpr double logistic_over_normal = 0.6;  // the scales of laws that look alike
constexpr double least_broad_scale = 0.1;
constexpr double largest_mode_step = 1, largest_scale_step = 0.7;  // in scales, of ln scale
constexpr int most_tilt_steps = 6;
constexpr double largest_tilt_step = 0.5, largest_tilt = 2;  // of the logarithm of a density
constexpr double no_light = 1e-12;  // of the layer's largest density: kept so that light may return

/// A layer while it is fitted.
template <std::size_t count>
struct Layer {
  std::array<std::uint32_t, count> bin;  ///< where the knot is
  std::array<double, count> density{}, mode{}, scale_below{}, scale_above{};
  double least_scale = Ribbon::least_scale;

  double azimuth(std::size_t k) const { return ExitColumns::azimuth(bin[k]); }
  double width(std::size_t k) const {
    const std::uint32_t bins = k + 1 < count ? bin[k + 1] - bin[k] : bin[0] + ExitColumns::bins - bin[k];
    return 2 * pi * bins / ExitColumns::bins;
  }
  double hat(std::size_t k) const { return 0.5 * (width(k) + width(before(k))); }
  static std::size_t before(std::size_t k) { return (k + count - 1) % count; }
  static std::size_t after(std::size_t k) { return (k + 1) % count; }

  RibbonSegment segment(std::size_t k, bool before_first) const {
    const std::size_t next = after(k);
    const auto pair = [&](const std::array<double, count>& of, float(&out)[2]) {
      out[0] = static_cast<float>(of[k]);
      out[1] = static_cast<float>(of[next]);
    };
    RibbonSegment s;
    s.x0 = static_cast<float>(azimuth(k) - (before_first ? 2 * pi : 0));
    s.inverse_width = static_cast<float>(1 / width(k));
    pair(density, s.density);
    pair(mode, s.mode);
    pair(scale_below, s.scale_below);
    pair(scale_above, s.scale_above);
    return s;
  }
};

/// Exits between two knots of either layer.
struct Piece {
  std::uint32_t begin, end;
  std::size_t main, broad;
  bool before_first;  ///< knot of the main layer, on the way round from its last
};

using Main = Layer<main_knots>;
using Broad = Layer<broad_knots>;

/// Numbers that describe a law (E9): what a Fisher information is made of.
struct LawInformation {
  double mode, cross, scale;
};
LawInformation information_of(HeightLaw law) {
  if (law == HeightLaw::normal) return {1, 2 * std::sqrt(2 / pi), 3};
  return {1.0 / 3, (1 + 2 * std::numbers::ln2) / 3, 1 + (3 + pi * pi) / 9};
}

/// A positive definite band matrix by its lower half, five off the diagonal: knots of three numbers, neighbours
/// coupled.
class Band {
 public:
  static constexpr std::size_t reach = 6, most = 3 * main_knots;
  explicit Band(std::size_t size) : size_(size) {}

  /// Row i and column j <= i, of at most reach - 1 apart.
  double& at(std::size_t i, std::size_t j) { return rows_[i][i - j]; }
  std::size_t size() const { return size_; }

  /// Solves in place by L D L^T; on the diagonal stand the inverses of D then. A pivot that is none leaves its entry 0.
  void solve(std::array<double, most>& right) {
    for (std::size_t i = 0; i < size_; ++i) {
      const std::size_t first = i + 1 > reach ? i + 1 - reach : 0;
      double pivot = at(i, i);
      for (std::size_t j = first; j < i; ++j) {  // the row of L D first, then of L
        double sum = at(i, j);
        for (std::size_t k = first; k < j; ++k) sum -= at(i, k) * at(j, k);
        at(i, j) = sum;
      }
      for (std::size_t j = first; j < i; ++j) {
        const double factor = at(i, j) * at(j, j);
        pivot -= factor * at(i, j);
        at(i, j) = factor;
        right[i] -= factor * right[j];
      }
      at(i, i) = pivot > 0 ? 1 / pivot : 0;
    }
    for (std::size_t i = size_; i-- > 0;) {
      right[i] *= at(i, i);
      for (std::size_t j = i + 1; j < std::min(i + reach, size_); ++j) right[i] -= at(j, i) * right[j];
    }
  }

 private:
  std::size_t size_;
  std::array<std::array<double, reach>, most> rows_{};  ///< rows_[i][d] stands at (i, i - d)
};
using Steps = std::array<double, Band::most>;

class Fitter {
 public:
  Fitter(const ExitColumns& exits, bool decays, const RibbonFitRule& rule)
      : exits_(exits), decays_(decays), rule_(rule) {
    double sum = 0, squares = 0;
    for (std::size_t i = 0; i < exits.size(); ++i) {
      sum += static_cast<double>(exits.w[i]);
      squares += static_cast<double>(exits.w[i]) * static_cast<double>(exits.w[i]);
    }
    count_ = squares > 0 ? sum * sum / squares : 1;
    const double scale = sum > 0 ? count_ / sum : 0;
    weights_.resize(exits.w.size(), 0.0f);
    for (std::size_t i = 0; i < exits.size(); ++i) {
      weights_[i] = static_cast<float>(scale * static_cast<double>(exits.w[i]));
    }
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
      match_moments();
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
      for (std::uint32_t i = exits_.begin[bin]; i < exits_.begin[bin + 1]; ++i)
        light += static_cast<double>(weights_[i]);
      below[bin + 1] = below[bin] + quantile_share * light / count_ + (1 - quantile_share) / ExitColumns::bins;
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
      if (exits_.begin[end] > exits_.begin[bin]) {
        pieces_.push_back({exits_.begin[bin], exits_.begin[end], main, broad, before_first});
      }
      bin = end;
    }
  }

  RibbonExits exits_of(const Piece& piece) const {
    return {exits_.x.data() + piece.begin, exits_.t.data() + piece.begin, weights_.data() + piece.begin,
            piece.end - piece.begin};
  }

  /// Masses, means and widths of the light of each hat.
  template <std::size_t count>
  void start_layer(Layer<count>& layer, std::size_t Piece::* segment, double share, double narrower) {
    std::array<double, count> w{}, wt{}, wtt{};
    double all_t = 0, all_tt = 0;
    for (const Piece& piece : pieces_) {
      const std::size_t k = piece.*segment, next = layer.after(k);
      const RibbonSegment s = layer.segment(k, count == main_knots && piece.before_first);
      for (std::uint32_t i = piece.begin; i < piece.end; ++i) {
        const double at = static_cast<double>((exits_.x[i] - s.x0) * s.inverse_width);
        const double weight = static_cast<double>(weights_[i]), t = static_cast<double>(exits_.t[i]);
        w[k] += (1 - at) * weight, wt[k] += (1 - at) * weight * t, wtt[k] += (1 - at) * weight * t * t;
        w[next] += at * weight, wt[next] += at * weight * t, wtt[next] += at * weight * t * t;
        all_t += weight * t;
        all_tt += weight * t * t;
      }
    }
    constexpr double added = 1;  // exits of the mean of all
    const double mean = all_t / count_, square = all_tt / count_;
    for (std::size_t k = 0; k < count; ++k) {
      const double n = w[k] + added, middle = (wt[k] + added * mean) / n;
      const double variance = std::max((wtt[k] + added * square) / n - middle * middle, 0.0);
      layer.mode[k] = std::clamp(middle, -double{Ribbon::largest_mode}, double{Ribbon::largest_mode});
      layer.scale_below[k] = layer.scale_above[k] =
          std::clamp(narrower * std::sqrt(variance), layer.least_scale, double{Ribbon::largest_scale});
      layer.density[k] = share * (w[k] + added / count * 0.1) / (count_ + 0.1 * added) / layer.hat(k);
    }
  }

  void start() {
    const double of_normal = 0.7, of_logistic = 0.4;
    start_layer(main_, &Piece::main, 1 - first_broad_share, law_ == HeightLaw::normal ? of_normal : of_logistic);
    start_layer(broad_, &Piece::broad, first_broad_share, 0.7);
  }

  template <std::size_t count>
  static void start_from(Layer<count>& layer, std::span<const RibbonKnot> knots) {
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
    scale_to_one();
  }

  void widen(double by) {
    for (std::size_t k = 0; k < main_knots; ++k) {
      for (double* scale : {&main_.scale_below[k], &main_.scale_above[k]}) {
        *scale = std::clamp(*scale * by, main_.least_scale, double{Ribbon::largest_scale});
      }
    }
  }

  void scale_to_one() {
    double mass = 0;
    for (std::size_t k = 0; k < main_knots; ++k) mass += main_.density[k] * main_.hat(k);
    for (std::size_t k = 0; k < broad_knots; ++k) mass += broad_.density[k] * broad_.hat(k);
    if (!(mass > 0)) return;
    for (double& density : main_.density) density /= mass;
    for (double& density : broad_.density) density /= mass;
  }

  /// The light of each knot's hat, with the prior that its density is the mean of its neighbours'.
  template <std::size_t count>
  void move_densities(Layer<count>& layer, const std::array<SegmentSums, count>& sums) {
    std::array<double, count> next;
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t b = layer.before(k);
      const double light = layer.density[k] * (sums[b].light[1] + sums[k].light[0]);
      const double to_before = layer.width(b), to_after = layer.width(k);
      const double between =
          (layer.density[b] * to_after + layer.density[layer.after(k)] * to_before) / (to_before + to_after);
      const double expected = count_ * layer.hat(k) * between, prior = rule_.density_prior;
      const double known = 0.5 * (light + expected);  // exits that tell it
      next[k] = (known * light + prior * expected) / (known + prior) / (count_ * layer.hat(k));
    }
    const double largest = *std::max_element(next.begin(), next.end());
    for (std::size_t k = 0; k < count; ++k) layer.density[k] = std::max(next[k], no_light * largest);
  }

  /// A step of Fisher scoring for modes and scales: knots in units of their scales, neighbours coupled by the hats.
  template <std::size_t count>
  void move_shapes(Layer<count>& layer, HeightLaw law, const std::array<SegmentSums, count>& sums) {
    const LawInformation known = information_of(law);
    Band matrix(3 * count);
    Steps step{};
    std::array<std::array<double, 3>, count> unit;
    for (std::size_t k = 0; k < count; ++k) {
      unit[k] = {std::sqrt(layer.scale_below[k] * layer.scale_above[k]), layer.scale_below[k], layer.scale_above[k]};
    }
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t next = layer.after(k);
      const SegmentSums& s = sums[k];
      const std::array<std::size_t, 2> ends{k, next};
      for (std::size_t e = 0; e < 2; ++e) {
        step[3 * ends[e]] += s.mode[e] * unit[ends[e]][0];
        step[3 * ends[e] + 1] += s.scale_below[e] * unit[ends[e]][1];
        step[3 * ends[e] + 2] += s.scale_above[e] * unit[ends[e]][2];
      }
      const double below = layer.scale_below[k] + layer.scale_below[next],
                   above = layer.scale_above[k] + layer.scale_above[next];
      const double p = below / (below + above), q = 1 - p;
      const double fisher[3][3] = {{known.mode, -known.cross * q, known.cross * p},
                                   {-known.cross * q, (known.scale - p) * q, -p * q},
                                   {known.cross * p, -p * q, (known.scale - q) * p}};
      const bool wraps = next < k;
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) {
          if (j <= i) {
            matrix.at(3 * k + i, 3 * k + j) += s.information[0] * fisher[i][j] * unit[k][i] * unit[k][j];
            matrix.at(3 * next + i, 3 * next + j) += s.information[2] * fisher[i][j] * unit[next][i] * unit[next][j];
          }
          if (!wraps) {
            matrix.at(3 * next + i, 3 * k + j) += s.information[1] * fisher[i][j] * unit[next][i] * unit[k][j];
          }
        }
      }
      const double scales[2] = {unit[k][0], unit[next][0]};
      const double apart = layer.mode[k] - layer.mode[next], between = scales[0] * scales[1];
      couple(matrix, step, 3 * k, 3 * next, wraps, rule_.mode_prior, apart, scales[0] / std::sqrt(between),
             scales[1] / std::sqrt(between), 1 / std::sqrt(between));
      couple(matrix, step, 3 * k + 1, 3 * next + 1, wraps, rule_.scale_prior,
             std::log(layer.scale_below[k] / layer.scale_below[next]), 1, 1, 1);
      couple(matrix, step, 3 * k + 2, 3 * next + 2, wraps, rule_.scale_prior,
             std::log(layer.scale_above[k] / layer.scale_above[next]), 1, 1, 1);
    }
    for (std::size_t i = 0; i < 3 * count; ++i) matrix.at(i, i) = matrix.at(i, i) * 1.001 + 1e-3;
    matrix.solve(step);
    for (std::size_t k = 0; k < count; ++k) {
      const double mode = layer.mode[k] + unit[k][0] * std::clamp(step[3 * k], -largest_mode_step, largest_mode_step);
      layer.mode[k] = std::clamp(mode, -double{Ribbon::largest_mode}, double{Ribbon::largest_mode});
      const auto move = [&](double scale, double by) {
        return std::clamp(scale * std::exp(std::clamp(by, -largest_scale_step, largest_scale_step)), layer.least_scale,
                          double{Ribbon::largest_scale});
      };
      layer.scale_below[k] = move(layer.scale_below[k], step[3 * k + 1]);
      layer.scale_above[k] = move(layer.scale_above[k], step[3 * k + 2]);
    }
  }

  /// The prior strength/2 (apart/unit)^2 of two neighbours whose numbers move by `a` and `b` units.
  static void couple(Band& matrix, Steps& step, std::size_t i, std::size_t j, bool wraps, double strength, double apart,
                     double a, double b, double per_unit) {
    step[i] -= strength * apart * per_unit * a;
    step[j] += strength * apart * per_unit * b;
    matrix.at(i, i) += strength * a * a * (wraps ? 2 : 1);
    matrix.at(j, j) += strength * b * b * (wraps ? 2 : 1);
    if (!wraps) matrix.at(j, i) -= strength * a * b;
  }

  void round() {
    std::array<SegmentSums, main_knots> main_sums{};
    std::array<SegmentSums, broad_knots> broad_sums{};
    for (const Piece& piece : pieces_) {
      add_exits(main_.segment(piece.main, piece.before_first), law_, broad_.segment(piece.broad, false),
                exits_of(piece), main_sums[piece.main], broad_sums[piece.broad]);
    }
    move_shapes(main_, law_, main_sums);
    move_shapes(broad_, HeightLaw::logistic, broad_sums);
    move_densities(main_, main_sums);
    move_densities(broad_, broad_sums);
    scale_to_one();
  }

  static constexpr std::size_t moments = 4;  ///< cos x, sin x, cos 2x, sin 2x
  using Moments = std::array<double, moments>;

  static Moments harmonics(double x) { return {std::cos(x), std::sin(x), std::cos(2 * x), std::sin(2 * x)}; }

  /// Of the integral over (1 - s/width) e^(i order s), s from 0 to width.
  static std::complex<double> half_hat(double order, double width) {
    const std::complex<double> turn(0, order);
    return std::complex<double>(0, 1 / order) + (1.0 - std::exp(turn * width)) / (order * order * width);
  }
  /// The moments of a knot's hat.
  template <std::size_t count>
  static Moments hat_moments(const Layer<count>& layer, std::size_t k) {
    Moments sums;
    for (const int order : {1, 2}) {
      const double n = order, right = layer.width(k), left = layer.width(layer.before(k));
      const std::complex<double> sum =
          std::exp(std::complex<double>(0, n * layer.azimuth(k))) * (half_hat(n, right) + std::conj(half_hat(n, left)));
      sums[static_cast<std::size_t>(2 * order - 2)] = sum.real();
      sums[static_cast<std::size_t>(2 * order - 1)] = sum.imag();
    }
    return sums;
  }

  struct Harmonic {
    double* density;
    double before, hat;  ///< density before the tilt; mass of the hat
    Moments at, of_hat;
  };

  template <std::size_t count>
  static void list_harmonics(Layer<count>& layer, std::vector<Harmonic>& out) {
    for (std::size_t k = 0; k < count; ++k) {
      out.push_back(
          {&layer.density[k], layer.density[k], layer.hat(k), harmonics(layer.azimuth(k)), hat_moments(layer, k)});
    }
  }

  /// Tilts the densities by e^(sum_j lambda_j harmonic_j), so that the mean directions are those of the exits: the
  /// prior and the straight lines between knots would widen every lobe a little to the same side, and with many
  /// scatterings that shows as brightness. Newton's method; as they were where there is no such tilt.
  void match_moments() {
    Moments wanted{};
    for (std::size_t i = 0; i < exits_.size(); ++i) {
      const Moments at = harmonics(static_cast<double>(exits_.x[i]));
      for (std::size_t j = 0; j < moments; ++j) wanted[j] += static_cast<double>(weights_[i]) / count_ * at[j];
    }
    std::vector<Harmonic> knots;
    list_harmonics(main_, knots);
    list_harmonics(broad_, knots);
    Eigen::Vector4d lambda = Eigen::Vector4d::Zero(), best = lambda;
    double least_off = std::numeric_limits<double>::infinity();
    for (int step = 0; step < most_tilt_steps; ++step) {
      double mass = 0;
      Eigen::Vector4d sums = Eigen::Vector4d::Zero(), mass_slopes = sums;
      Eigen::Matrix4d slopes = Eigen::Matrix4d::Zero();
      for (const Harmonic& knot : knots) {
        const Eigen::Vector4d at(knot.at.data()), of_hat(knot.of_hat.data());
        const double density = knot.before * std::exp(lambda.dot(at));
        mass += density * knot.hat;
        sums += density * of_hat;
        mass_slopes += density * knot.hat * at;
        slopes += density * of_hat * at.transpose();
      }
      const Eigen::Vector4d off = Eigen::Vector4d(wanted.data()) - sums / mass;
      if (!off.allFinite()) break;
      if (off.norm() < least_off) {
        least_off = off.norm();
        best = lambda;
      }
      const Eigen::Matrix4d jacobian = slopes / mass - sums * mass_slopes.transpose() / (mass * mass);
      const Eigen::Vector4d by = jacobian.fullPivLu().solve(off);
      if (!by.allFinite()) break;
      lambda += by * std::min(1.0, largest_tilt_step / std::max(by.norm(), 1e-12));
      if (lambda.norm() > largest_tilt) break;
    }
    for (const Harmonic& knot : knots) {
      *knot.density = knot.before * std::exp(best.dot(Eigen::Vector4d(knot.at.data())));
    }
    scale_to_one();
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
    std::vector<float> density(exits_.x.size()), main_share(exits_.x.size());
    double likelihood = 0;
    for (const Piece& piece : pieces_) {
      evaluate_exits(main_.segment(piece.main, piece.before_first), law_, broad_.segment(piece.broad, false),
                     exits_of(piece), density.data() + piece.begin, main_share.data() + piece.begin);
    }
    for (std::size_t i = 0; i < exits_.size(); ++i) {
      likelihood += static_cast<double>(weights_[i]) * static_cast<double>(std::log(density[i]));
    }
    if (decays_) write_decays(main_share, main, broad);
    return {Ribbon(main, law_, broad), likelihood / count_};
  }

  /// Light, and what is left of it at both rates.
  struct Light {
    double all = 0;
    std::array<double, 2> left{};
    void add(double weight, const std::array<float, 2>& decays) {
      all += weight;
      for (std::size_t r = 0; r < 2; ++r) left[r] += weight * static_cast<double>(decays[r]);
    }
  };

  void write_decays(const std::vector<float>& main_share, std::span<RibbonKnot> main,
                    std::span<RibbonKnot> broad) const {
    std::array<Light, main_knots> of_main;
    std::array<Light, broad_knots> of_broad;
    Light all;
    for (const Piece& piece : pieces_) {
      const RibbonSegment in_main = main_.segment(piece.main, piece.before_first),
                          in_broad = broad_.segment(piece.broad, false);
      for (std::uint32_t i = piece.begin; i < piece.end; ++i) {
        const std::array<float, 2> decays{std::exp(-Ribbon::decay_rates[0] * exits_.attribute[i]),
                                          std::exp(-Ribbon::decay_rates[1] * exits_.attribute[i])};
        const double w = static_cast<double>(weights_[i]), m = w * static_cast<double>(main_share[i]);
        const double s = static_cast<double>((exits_.x[i] - in_main.x0) * in_main.inverse_width);
        const double q = static_cast<double>((exits_.x[i] - in_broad.x0) * in_broad.inverse_width);
        of_main[piece.main].add(m * (1 - s), decays);
        of_main[Main::after(piece.main)].add(m * s, decays);
        of_broad[piece.broad].add((w - m) * (1 - q), decays);
        of_broad[Broad::after(piece.broad)].add((w - m) * q, decays);
        all.add(w, decays);
      }
    }
    if (!(all.all > 0)) return;
    const auto write = [&](std::span<const Light> light, std::span<RibbonKnot> knots) {
      constexpr double prior = 2;  // exits of the mean of all
      for (std::size_t k = 0; k < knots.size(); ++k) {
        for (std::size_t r = 0; r < 2; ++r) {
          const double mean = (light[k].left[r] + prior * all.left[r] / all.all) / (light[k].all + prior);
          knots[k].decays[r] = static_cast<float>(std::clamp(mean, 0.0, 1.0));
        }
      }
    };
    write(of_main, main);
    write(of_broad, broad);
  }

  const ExitColumns& exits_;
  bool decays_;
  RibbonFitRule rule_;
  double count_;                ///< as many exits of equal weight tell as much
  std::vector<float> weights_;  ///< adding up to count_
  HeightLaw law_ = HeightLaw::logistic;
  Main main_;
  Broad broad_;
  std::vector<Piece> pieces_;
};

}  // namespace

RibbonFit fit_ribbon(const ExitColumns& exits, const Ribbon* earlier, bool decays, const RibbonFitRule& rule) {
  return Fitter(exits, decays, rule).fit(earlier);
}

}  // namespace tress::adaptive
