#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "tress/adaptive/ribbon.h"

namespace tress::adaptive {
namespace {

constexpr double largest_scale = 1e12;
constexpr float least_decay = 1e-30f;
constexpr double first_rate = Ribbon::decay_rates[0], second_rate = Ribbon::decay_rates[1];
constexpr double most_ratio = second_rate / first_rate;  ///< the ratio at scale 0

/// ln of the second decay over ln of the first, for the gamma law, where l = ln(1 + first_rate scale). It falls from
/// most_ratio at l = 0 towards 1.
double ratio_of(double l) { return std::log1p(most_ratio * std::expm1(l)) / l; }

/// Gives l for a ratio, by cubics on equal steps of v = ln((most_ratio - 1)/(ratio - 1)); l rises like e^v. The error
/// is 1e-8 of l.
class LogarithmOfRatio {
 public:
  LogarithmOfRatio() {
    least_l_ = std::log1p(first_rate * static_cast<double>(GammaDecay::least_scale));
    const double most_l = std::log1p(first_rate * largest_scale);
    least_v_ = v_of(ratio_of(least_l_));
    most_v_ = v_of(ratio_of(most_l));
    const double step = (most_v_ - least_v_) / steps;
    per_step_ = 1 / step;
    double l = least_l_;
    for (std::size_t i = 0; i <= steps; ++i) {
      const double v = least_v_ + step * static_cast<double>(i);
      for (int newton = 0; newton < 60; ++newton) {
        const double by = (v - v_of(ratio_of(l))) * slope_at(l);
        l = std::clamp(l + by, least_l_, most_l);
        if (std::abs(by) < 1e-14 * l) break;
      }
      at_[i] = {l, slope_at(l) * step};
    }
  }
  double operator()(double ratio) const {
    const double v = ratio > 1 ? std::clamp(v_of(ratio), least_v_, most_v_) : most_v_;
    const double place = (v - least_v_) * per_step_;
    const std::size_t i = std::min(static_cast<std::size_t>(place), steps - 1);
    const double s = place - static_cast<double>(i);
    const Point &a = at_[i], &b = at_[i + 1];
    const double rise = b.l - a.l;
    return a.l + s * (a.slope + s * (3 * rise - 2 * a.slope - b.slope + s * (a.slope + b.slope - 2 * rise)));
  }

 private:
  static constexpr std::size_t steps = 256;
  struct Point {
    double l, slope;  ///< slope: change of l in one step of v
  };
  static double v_of(double ratio) { return std::log((most_ratio - 1) / (ratio - 1)); }
  /// Returns dl/dv = -(ratio - 1)/(d ratio/dl).
  static double slope_at(double l) {
    const double ratio = ratio_of(l), grown = most_ratio * std::expm1(l);
    const double of_log = most_ratio * std::exp(l) / (1 + grown);
    return -(ratio - 1) * l / (of_log - ratio);
  }

  double least_l_, least_v_, most_v_, per_step_;
  std::array<Point, steps + 1> at_;
};

}  // namespace

GammaDecay GammaDecay::from(const std::array<float, 2>& decays) {
  static const LogarithmOfRatio logarithm_of;
  const double first = -std::log(static_cast<double>(std::clamp(decays[0], least_decay, 1.0f)));
  const double second = -std::log(static_cast<double>(std::clamp(decays[1], least_decay, 1.0f)));
  if (!(first > 0)) return {};
  const double l = logarithm_of(second / first);
  return {static_cast<float>(first / l), static_cast<float>(std::expm1(l) / first_rate)};
}

float GammaDecay::at(float rate) const { return std::exp(-shape * std::log1p(scale * rate)); }

}  // namespace tress::adaptive
