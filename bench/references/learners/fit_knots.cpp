#include "references/learners/fit_knots.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include "base/pi.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr std::size_t points_a_cell = 4;
// Boole's rule over a cell of length 1: both ends and the three points between. It is exact for polynomials up to
// degree 5, and so for the squared difference of a parabola and a line.
constexpr std::array boole{7.0 / 90, 32.0 / 90, 12.0 / 90, 32.0 / 90, 7.0 / 90};

/// The samples that are fitted to: g at four points per cell, beginning at -pi.
class Samples {
 public:
  explicit Samples(const TracedNodes& nodes) : nodes_(nodes) {}

  /// Evaluates what is missing for `cells`: the earlier points are every other one of the new ones.
  void refine(std::size_t cells) {
    const std::size_t points = cells * points_a_cell;
    std::vector<double> finer(points);
    for (std::size_t i = 0; i < points; ++i) {
      const bool known = i % 2 == 0 && g_.size() * 2 == points;
      finer[i] = known ? g_[i / 2] : evaluate(i, points);
    }
    g_ = std::move(finer);
  }

  std::size_t cells() const { return g_.size() / points_a_cell; }
  /// Point `i` of a cell, 0 to 4; the last is the first of the next cell.
  double at(std::size_t cell, std::size_t i) const { return g_[(cell * points_a_cell + i) % g_.size()]; }
  std::uint32_t evaluations() const { return evaluations_; }

 private:
  double evaluate(std::size_t i, std::size_t points) {
    ++evaluations_;
    return nodes_.density(static_cast<float>((static_cast<double>(i) / static_cast<double>(points) - 0.5) * two_pi));
  }

  const TracedNodes& nodes_;
  std::vector<double> g_;
  std::uint32_t evaluations_ = 0;
};

/// Returns the densities f that minimise the integral of (g - f)^2: (f_(k-1) + 4 f_k + f_(k+1))/6 = 1/h integral of g
/// hat_k. The matrix is circulant; its inverse is the recursive filter of pole z = sqrt 3 - 2, run once each way round.
std::vector<double> project(const Samples& samples) {
  const std::size_t n = samples.cells();
  std::vector<double> f(n, 0.0);
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t i = 0; i <= points_a_cell; ++i) {
      const double along = static_cast<double>(i) / points_a_cell;
      const double part = boole[i] * samples.at(k, i);
      f[k] += (1 - along) * part;
      f[(k + 1) % n] += along * part;
    }
  }
  const double z = std::numbers::sqrt3 - 2;
  double first = 0;  // value of the filter after endless rounds
  for (std::size_t j = 0; j < n; ++j) first = first * z + f[(j + 1) % n];
  first /= 1 - std::pow(z, static_cast<double>(n));
  f[0] = first;
  for (std::size_t k = 1; k < n; ++k) f[k] += z * f[k - 1];
  double last = 0;
  for (std::size_t j = n; j-- > 0;) last = last * z + f[(j + n - 1) % n];
  last /= 1 - std::pow(z, static_cast<double>(n));
  f[n - 1] = last;
  for (std::size_t k = n - 1; k-- > 0;) f[k] += z * f[k + 1];
  for (double& value : f) value *= -6 * z;
  return f;
}

/// Makes all densities >= 0 and scales them to the mass `energy`.
void scale_to(double energy, std::vector<double>& f) {
  double sum = 0;
  for (double& value : f) sum += value = std::max(value, 0.0);
  const double wanted = energy * static_cast<double>(f.size()) / two_pi;
  for (double& value : f) value = sum > 0 ? value * (wanted / sum) : energy / two_pi;
}

/// Returns the integral of (g - f)^2.
double squared_error(const Samples& samples, const std::vector<double>& f) {
  const std::size_t n = samples.cells();
  double sum = 0;
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t i = 0; i <= points_a_cell; ++i) {
      const double along = static_cast<double>(i) / points_a_cell;
      const double r = samples.at(k, i) - (f[k] + along * (f[(k + 1) % n] - f[k]));
      sum += boole[i] * r * r;
    }
  }
  return sum * two_pi / static_cast<double>(n);
}

}  // namespace

KnotFit fit_knots(const TracedNodes& nodes, double epsilon) {
  KnotFit fit;
  // Boole's rule cannot resolve features narrower than the distance of its points.
  constexpr double finest = two_pi / (points_a_cell * KnotDensity::most);
  if (nodes.blur_rad() < finest) {
    const Knot flat{.density = nodes.energy() / static_cast<float>(two_pi)};
    fit.table = KnotDensity(std::vector<Knot>(KnotDensity::fewest, flat));
    fit.objective = 1;  // an upper bound: integral (g - mean)^2 / L
    return fit;
  }
  Samples samples(nodes);
  std::vector<double> f;
  for (std::size_t count = KnotDensity::fewest;; count *= 2) {
    samples.refine(count);
    f = project(samples);
    scale_to(nodes.energy(), f);
    fit.objective = squared_error(samples, f) / static_cast<double>(nodes.variation());
    if (fit.objective <= epsilon / 4 || count == KnotDensity::most) break;
  }
  std::vector<Knot> knots(f.size());
  for (std::size_t k = 0; k < f.size(); ++k) knots[k].density = static_cast<float>(f[k]);
  fit.table = KnotDensity(std::move(knots));
  fit.evaluations = samples.evaluations();
  return fit;
}

}  // namespace tress::inline v0_2::adaptive
