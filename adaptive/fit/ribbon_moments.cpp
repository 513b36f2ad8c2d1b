#include "fit/ribbon_moments.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <limits>
#include <vector>

namespace tress::adaptive {
namespace {

constexpr int most_tilt_steps = 6;
constexpr double largest_tilt_step = 0.5, largest_tilt = 2;  // of the logarithm of a density

constexpr std::size_t moments = 4;  ///< cos x, sin x, cos 2x, sin 2x
using Moments = std::array<double, moments>;

template <class Number>
Moments harmonics(Number x) {
  const auto c = static_cast<double>(std::cos(x)), s = static_cast<double>(std::sin(x));
  return {c, s, c * c - s * s, 2 * s * c};
}

/// Of the integral over (1 - s/width) e^(i order s), s from 0 to width.
std::complex<double> half_hat(double order, double width) {
  const std::complex<double> turn(0, order);
  return std::complex<double>(0, 1 / order) + (1.0 - std::exp(turn * width)) / (order * order * width);
}
/// The moments of a knot's hat.
template <std::size_t count>
Moments hat_moments(const RibbonLayer<count>& layer, std::size_t k) {
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
void list_harmonics(RibbonLayer<count>& layer, std::vector<Harmonic>& out) {
  for (std::size_t k = 0; k < count; ++k) {
    out.push_back(
        {&layer.density[k], layer.density[k], layer.hat(k), harmonics(layer.azimuth(k)), hat_moments(layer, k)});
  }
}

}  // namespace

Moments mean_harmonics(const RibbonLight& light) {
  Moments sums{};
  for (std::size_t i = 0; i < light.exits.size(); ++i) {
    const Moments at = harmonics(light.exits.x[i]);
    for (std::size_t j = 0; j < moments; ++j) sums[j] += static_cast<double>(light.weights[i]) * at[j];
  }
  for (double& sum : sums) sum /= light.count;
  return sums;
}

void match_moments(const RibbonLight& light, MainLayer& main, BroadLayer& broad) {
  std::vector<Harmonic> knots;
  list_harmonics(main, knots);
  list_harmonics(broad, knots);
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
    const Eigen::Vector4d off = Eigen::Vector4d(light.harmonics.data()) - sums / mass;
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
  scale_to_one(main, broad);
}

}  // namespace tress::adaptive
