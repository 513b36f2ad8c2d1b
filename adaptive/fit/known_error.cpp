#include "fit/known_error.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "base/pi.h"
#include "fit/kernels.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr double steps_a_scale = 2;

double narrowest_scale(const Mixture& fit) {
  double narrowest = 1;
  for (const Component& part : fit.parts()) {
    narrowest = std::min<double>(narrowest, std::min(part.shape.s_left, part.shape.s_right));
  }
  return narrowest;
}

/// Returns f at -pi + (i + shift) 2 pi/n, i < n. The result is padded for the kernels.
std::vector<double> densities(const Mixture& fit, std::size_t n, double shift, std::vector<double>& azimuth) {
  azimuth.assign(padded_size(n), 0.0);
  for (std::size_t i = 0; i < n; ++i)
    azimuth[i] = ((static_cast<double>(i) + shift) / static_cast<double>(n) - 0.5) * 2 * pi;
  std::vector<double> f(padded_size(n), fit.uniform_weight / (2 * pi));
  for (const Component& part : fit.parts()) {
    add_density(Shape(part.shape.mu, part.shape.s_left, part.shape.s_right), part.weight, azimuth.data(), f.size(),
                f.data());
  }
  return f;
}

/// The trigonometric polynomial through n values at equal steps, evaluated between them.
class Interpolation {
 public:
  explicit Interpolation(std::span<const float> values)
      : n_(values.size()), twice_(2 * n_ + kernel_lanes), kernel_(n_) {
    for (std::size_t i = 0; i < twice_.size(); ++i) twice_[i] = values[i % n_];
  }

  /// Evaluates at every step plus the fraction `shift` of one, 0 < shift < 1.
  std::vector<double> at(double shift) {
    const auto n = static_cast<double>(n_);
    // Value i is the sum over j of D(i + shift - j) times value j; D(t) = sin(pi t)/(n tan(pi t/n)), or with sin for
    // tan where n is odd.
    for (std::size_t k = 0; k < n_; ++k) {
      const double t = shift - static_cast<double>(k);
      const double x = pi * t / n;
      kernel_[k] = std::sin(pi * t) / (n * (n_ % 2 == 0 ? std::tan(x) : std::sin(x)));
    }
    std::vector<double> result(padded_size(n_));
    blur_row(twice_.data(), kernel_.data(), n_, result.data(), n_);
    return result;
  }

 private:
  std::size_t n_;
  std::vector<double> twice_, kernel_;
};

/// Bounds the squared norm of the part of g that n values at equal steps do not show: frequencies from n/2 on, both
/// where they are and where they are aliased to.
double unseen(const TracedNodes& nodes, double n) {
  const double blur = nodes.blur_rad(), energy = nodes.energy();
  return 3 / pi * energy * energy * std::exp(-n * n * blur * blur / 4) * (1 + 1 / (n * blur * blur));
}

}  // namespace

KnownError known_error(const Mixture& fit, const TracedNodes& nodes, std::span<const float> grid) {
  const std::size_t n = grid.size();
  const double step = 2 * pi / static_cast<double>(n);
  const auto finer = static_cast<std::size_t>(std::ceil(steps_a_scale * step / narrowest_scale(fit)));
  Interpolation g(grid);
  std::vector<double> azimuth;
  double sum = 0;
  for (std::size_t phase = 0; phase < finer; ++phase) {
    const double shift = static_cast<double>(phase) / static_cast<double>(finer);
    const std::vector<double> f = densities(fit, n, shift, azimuth);
    const std::vector<double> between = phase > 0 ? g.at(shift) : std::vector<double>(grid.begin(), grid.end());
    for (std::size_t i = 0; i < n; ++i) sum += (between[i] - f[i]) * (between[i] - f[i]);
  }
  const double seen = sum * step / static_cast<double>(finer);
  const double most = std::sqrt(seen) + std::sqrt(unseen(nodes, static_cast<double>(n)));
  const double variation = nodes.variation();
  return {seen / variation, most * most / variation};
}

}  // namespace tress::inline v0_2::adaptive
