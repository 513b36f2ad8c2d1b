// Integrals over all directions, and samples counted against them, of lobes of any width: panels where the samples of
// a pilot lie, split where two rules differ.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include "base/color.h"
#include "fiber/energy_table.h"
#include "fiber/longitudinal.h"
#include "models/model_measures.h"
#include "support/chi_square.h"
#include "tress/base/random.h"
#include "tress/fiber/fiber_model.h"

namespace tress::test {

struct PanelSettings {
  int samples = 4000;        ///< counted against the integrals of the density over the panels
  int pilot = 2000;          ///< others, by which the panels are laid
  long most_points = 60000;  ///< evaluations: past them nothing is split any more
  std::uint64_t seed = 1;
  /// S is as smooth as the density, so that panels are split for it too. False of `corrected`, whose S jumps from one
  /// direction to the next.
  bool smooth = true;
};

/// Of one event. Errors: root of the sum over the panels of the squared differences between the rules of 3 x 3 and of
/// 5 x 5 points; the values are of the latter.
struct PanelIntegrals {
  double pdf = 0, pdf_error = 0;
  double s = 0, s_error = 0;  ///< luminance
  double largest_weight = 0;  ///< |S|/Q at any point, of luminance
  long points = 0;
  long unsound = 0;  ///< of points and samples: not finite, below 0 (S of `corrected` may be), or S without Q
  ChiSquare fit;
  /// What the errors of the panels may add to the statistic of `fit`, in its own standard deviations.
  double fit_error = 0;
};

class DirectionPanels {
 public:
  DirectionPanels(const fiber::FiberModel& model, const fiber::FiberEvent& event, const PanelSettings& settings)
      : model_(model), event_(event), settings_(settings) {
    lay();
    std::vector<double> expected((theta_.size() - 1) * (phi_.size() - 1)), counts = expected;
    double excess = 0, s_squares = 0, pdf_squares = 0;
    for (std::size_t i = 0; i + 1 < theta_.size(); ++i) {
      std::vector<Sum> sums(phi_.size() - 1);
      std::vector<Arc> arcs;
      for (std::size_t j = 0; j < sums.size(); ++j) arcs.push_back({phi_[j], phi_[j + 1], j});
      integrate(theta_[i], theta_[i + 1], arcs, 0, sums);
      for (std::size_t j = 0; j < sums.size(); ++j) {
        const Sum& sum = sums[j];
        result_.pdf += sum.pdf;
        result_.s += sum.s;
        pdf_squares += sum.pdf_squares;
        s_squares += sum.s_squares;
        expected[bin(i, j)] = sum.pdf * settings.samples;
        if (sum.pdf * settings.samples > 1) excess += sum.pdf_squares / sum.pdf * settings.samples;
      }
    }
    result_.pdf_error = std::sqrt(pdf_squares);
    result_.s_error = std::sqrt(s_squares);
    RandomStream random(settings.seed, 1);
    for (int k = 0; k < settings.samples; ++k) {
      const fiber::FiberSample sample = draw(model, event, random);
      judge(sample.value);
      ++counts[bin(panel_of(theta_, double{sample.wi.theta}), panel_of(phi_, double{sample.wi.phi}))];
    }
    result_.fit = chi_square(counts, expected);
    result_.fit_error = excess / std::sqrt(2.0 * std::max(result_.fit.degrees_of_freedom, 1));
  }

  const PanelIntegrals& result() const { return result_; }

 private:
  /// A piece of the circle, and the panel of the first division that it is a part of.
  struct Arc {
    double from, to;
    std::size_t panel;
  };
  struct Sum {
    double pdf = 0, s = 0, pdf_squares = 0, s_squares = 0;
  };
  static constexpr int deepest = 8;

  std::size_t bin(std::size_t i, std::size_t j) const { return i * (phi_.size() - 1) + j; }
  static std::size_t panel_of(const std::vector<double>& edges, double x) {
    const auto after = std::upper_bound(edges.begin() + 1, edges.end() - 1, x);
    return static_cast<std::size_t>(after - edges.begin()) - 1;
  }

  /// Equal shares of the pilot's samples, and equal steps, so that no panel is wide where nothing was drawn.
  static std::vector<double> edges(std::vector<double> drawn, double end, int shares, int steps) {
    std::sort(drawn.begin(), drawn.end());
    std::vector<double> all;
    for (int k = 1; k < shares; ++k)
      all.push_back(drawn[drawn.size() * static_cast<std::size_t>(k) / static_cast<std::size_t>(shares)]);
    for (int k = 0; k <= steps; ++k) all.push_back(std::clamp(end * (2.0 * k / steps - 1), -end, end));
    std::sort(all.begin(), all.end());
    std::vector<double> apart{-end};
    for (const double x : all)
      if (x > apart.back() + 1e-5 * end && x < end * (1 - 1e-5)) apart.push_back(x);
    apart.push_back(end);
    return apart;
  }

  void lay() {
    std::vector<double> theta, phi;
    RandomStream random(settings_.seed, 0);
    for (int k = 0; k < settings_.pilot; ++k) {
      const fiber::FiberDirection wi = draw(model_, event_, random).wi;
      theta.push_back(double{wi.theta});
      phi.push_back(double{wi.phi});
    }
    theta_ = edges(theta, double{fiber::half_pi}, 10, 6);
    phi_ = edges(phi, std::numbers::pi, 14, 8);
    for (std::size_t k = 0; k < theta.size(); ++k) pilot_.push_back({theta[k], phi[k]});
  }

  void judge(const fiber::FiberValue& value) {
    const double q = double{value.pdf};
    bool sound = std::isfinite(q) && q >= 0;
    for (const glm::vec3& color : value.s) {
      for (int c = 0; c < 3; ++c) sound = sound && std::isfinite(color[c]) && (color[c] >= 0 || !settings_.smooth);
    }
    const double s = std::abs(double{luminance(value.total())});
    if (s > 0 && !(q > 0)) sound = false;
    if (!sound) {
      ++result_.unsound;
    } else if (q > 0) {
      result_.largest_weight = std::max(result_.largest_weight, s / q);
    }
  }

  /// Over theta in [from, to] and each of the arcs, theta_i outside: a trace at the vertex serves all of them.
  template <std::size_t n>
  std::vector<Sum> rule(double from, double to, const std::vector<Arc>& arcs, const std::array<double, n>& node,
                        const std::array<double, n>& weight) {
    const double centre = 0.5 * (from + to), half = 0.5 * (to - from);
    std::vector<Sum> sums(arcs.size());
    for (std::size_t i = 0; i < n; ++i) {
      const auto theta = static_cast<float>(centre + half * node[i]);
      for (std::size_t a = 0; a < arcs.size(); ++a) {
        const double centre_phi = 0.5 * (arcs[a].from + arcs[a].to), half_phi = 0.5 * (arcs[a].to - arcs[a].from);
        for (std::size_t j = 0; j < n; ++j) {
          const fiber::FiberValue at =
              model_.evaluate(event_, {theta, static_cast<float>(centre_phi + half_phi * node[j])});
          judge(at);
          const double area = half * weight[i] * half_phi * weight[j];
          sums[a].pdf += area * double{at.pdf};
          sums[a].s += area * double{luminance(at.total())};
        }
      }
    }
    result_.points += static_cast<long>(n * n * arcs.size());
    return sums;
  }

  /// Adds to `sums` of each arc's panel; splits in four where the rules differ.
  void integrate(double from, double to, const std::vector<Arc>& arcs, int depth, std::vector<Sum>& sums) {
    constexpr std::array<double, 3> node_3{-0.7745966692414834, 0, 0.7745966692414834},
        weight_3{0.5555555555555556, 0.8888888888888888, 0.5555555555555556};
    constexpr std::array<double, 5> node_5{-0.9061798459386640, -0.5384693101056831, 0, 0.5384693101056831,
                                           0.9061798459386640},
        weight_5{0.2369268850561891, 0.4786286704993665, 0.5688888888888889, 0.4786286704993665, 0.2369268850561891};
    const std::vector<Sum> coarse = rule(from, to, arcs, node_3, weight_3),
                           fine = rule(from, to, arcs, node_5, weight_5);
    // A share of the noise of the counts; a panel of less than a sample's mass counts as one of it.
    const auto allowed = [&](double mass) {
      return 0.04 / settings_.samples * std::sqrt(std::max(mass * settings_.samples, 1.0));
    };
    std::vector<double> drawn(arcs.size());
    for (const auto& [theta, phi] : pilot_) {
      if (!(theta >= from && theta < to)) continue;
      auto arc = std::upper_bound(arcs.begin(), arcs.end(), phi, [](double x, const Arc& one) { return x < one.from; });
      if (arc != arcs.begin() && phi < (--arc)->to) ++drawn[static_cast<std::size_t>(arc - arcs.begin())];
    }
    std::vector<Arc> split;
    for (std::size_t a = 0; a < arcs.size(); ++a) {
      // A spot between the points of both rules: the pilot has seen it.
      const double expected = std::max(fine[a].pdf, 0.0) * settings_.pilot;
      const bool seen = std::abs(drawn[a] - expected) <= 3 + 4 * std::sqrt(expected);
      const double pdf_off = fine[a].pdf - coarse[a].pdf, s_off = fine[a].s - coarse[a].s;
      const bool met = seen && std::abs(pdf_off) <= allowed(fine[a].pdf) &&
                       (!settings_.smooth || std::abs(s_off) <= allowed(fine[a].s));
      if (met || depth == deepest || result_.points > settings_.most_points) {
        Sum& sum = sums[arcs[a].panel];
        sum.pdf += fine[a].pdf;
        sum.s += fine[a].s;
        const double missed = seen ? 0 : drawn[a] / settings_.pilot - fine[a].pdf;
        sum.pdf_squares += pdf_off * pdf_off + missed * missed;
        sum.s_squares += s_off * s_off;
      } else {
        const double middle = 0.5 * (arcs[a].from + arcs[a].to);
        split.push_back({arcs[a].from, middle, arcs[a].panel});
        split.push_back({middle, arcs[a].to, arcs[a].panel});
      }
    }
    if (split.empty()) return;
    integrate(from, 0.5 * (from + to), split, depth + 1, sums);
    integrate(0.5 * (from + to), to, split, depth + 1, sums);
  }

  const fiber::FiberModel& model_;
  const fiber::FiberEvent& event_;
  PanelSettings settings_;
  std::vector<double> theta_, phi_;
  std::vector<std::array<double, 2>> pilot_;
  PanelIntegrals result_;
};

}  // namespace tress::test
