#include "fiber/path_rule.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tress::inline v0_2::fiber {
namespace {

constexpr double least_mass = 1e-14;
constexpr double least_variance = 1e-12;  // in the squared mean: below it, all lengths count as one
constexpr double least_third = 1e-8;      // squared norm of the monic p_2: below it there is no third point

/// Returns the roots of x^3 + c2 x^2 + c1 x + c0, all real and distinct, ascending.
std::array<double, 3> real_roots(double c2, double c1, double c0) {
  const double shift = c2 / 3, p = std::max(shift * shift - c1 / 3, 0.0);
  const double q = shift * (shift * shift - c1 / 2) + c0 / 2;
  const double radius = std::sqrt(p);
  const double angle = std::acos(std::clamp(p > 0 ? -q / (p * radius) : 0.0, -1.0, 1.0)) / 3;
  std::array<double, 3> roots;
  for (std::size_t k = 0; k < 3; ++k) {
    double x = 2 * radius * std::cos(angle + 2 * std::numbers::pi / 3 * (static_cast<double>(k) + 1)) - shift;
    const double slope = (3 * x + 2 * c2) * x + c1;
    if (slope != 0) x -= (((x + c2) * x + c1) * x + c0) / slope;
    roots[k] = x;
  }
  return roots;
}

}  // namespace

PathRule gauss_rule(const CentralMoments& m) {
  PathRule rule;
  rule.weight[0] = m.mass;
  rule.length[0] = std::max(m.mean, 0.0);
  if (!(m.mass > least_mass) || !(m.central[0] > least_variance * m.mean * m.mean)) return rule;
  // In units of the standard deviation the Jacobi matrix has the rows (0, 1, 0), (1, skew, b), (0, b, last).
  const double deviation = std::sqrt(m.central[0]), variance = m.central[0];
  const double skew = m.central[1] / (variance * deviation), fourth = m.central[2] / (variance * variance);
  const double fifth = m.central[3] / (variance * variance * deviation);
  const double b2 = fourth - skew * skew - 1;
  const auto put = [&](std::size_t k, double x, double norm) {
    rule.weight[k] = m.mass / norm;
    rule.length[k] = std::max(m.mean + deviation * x, 0.0);
  };
  if (!(b2 > least_third)) {
    const double root = std::sqrt(skew * skew + 4);
    for (std::size_t k = 0; k < 2; ++k) {
      const double x = 0.5 * (skew + (k == 0 ? -root : root));
      put(k, x, 1 + x * x);
    }
    return rule;
  }
  const double last = (fifth + skew * (skew * skew - 2 * fourth)) / b2;
  const std::array<double, 3> roots = real_roots(-(skew + last), skew * last - b2 - 1, last);
  for (std::size_t k = 0; k < 3; ++k) {
    const double x = roots[k], second = x * (x - skew) - 1;
    put(k, x, 1 + x * x + second * second / b2);
  }
  return rule;
}

CentralMoments central_moments(const std::array<double, 6>& raw) {
  CentralMoments m;
  m.mass = raw[0];
  if (!(m.mass > 0)) return m;
  const double c = m.mean = raw[1] / m.mass;
  const double r2 = raw[2] / m.mass, r3 = raw[3] / m.mass, r4 = raw[4] / m.mass, r5 = raw[5] / m.mass;
  m.central = {r2 - c * c, r3 - c * (3 * r2 - 2 * c * c), r4 - c * (4 * r3 - c * (6 * r2 - 3 * c * c)),
               r5 - c * (5 * r4 - c * (10 * r3 - c * (10 * r2 - 4 * c * c)))};
  return m;
}

}  // namespace tress::inline v0_2::fiber
