#include "references/models/marschner_azimuth.h"

#include <algorithm>
#include <cmath>

#include "base/pi.h"
#include "fiber/fresnel.h"

namespace tress::inline v0_2::fiber {
namespace {

double square(double x) { return x * x; }

/// Reflectance at gamma by the index `across` for s and `along` for p, each in two dimensions; 1 where it is total.
double two_index_fresnel(double across, double along, double cos_gamma) {
  const double sin2 = std::max(1 - cos_gamma * cos_gamma, 0.0);
  const auto inside = [&](double index) { return std::sqrt(std::max(index * index - sin2, 0.0)); };
  const double s = across * across > sin2 ? square((cos_gamma - inside(across)) / (cos_gamma + inside(across))) : 1;
  const double scaled = along * along * cos_gamma;
  // scaled + inside is 0 only for cos gamma = 0 and along = 1, where all is reflected.
  const double sum = scaled + inside(along);
  const double p = along * along > sin2 && sum > 0 ? square((scaled - inside(along)) / sum) : 1;
  return 0.5 * (s + p);
}

/// Real roots of a x^3 + b x = d, a < 0; b of either sign.
std::size_t roots_of(double a, double b, double d, std::array<double, 3>& root) {
  const double p = b / a, q = -d / a;  // x^3 + p x + q = 0
  if (p > 0) {
    const double radius = std::sqrt(p / 3);
    root[0] = -2 * radius * std::sinh(std::asinh(1.5 * q / (p * radius)) / 3);
    return 1;
  }
  const double radius = std::sqrt(-p / 3);
  const double argument = radius > 0 ? 0.5 * q / (radius * radius * radius) : 0;
  if (radius <= 0) {
    root[0] = -std::cbrt(q);
    return 1;
  }
  if (std::abs(argument) > 1) {
    root[0] = -2 * std::copysign(radius, q) * std::cosh(std::acosh(std::abs(argument)) / 3);
    return 1;
  }
  const double angle = std::acos(-argument) / 3;
  for (std::size_t k = 0; k < 3; ++k) root[k] = 2 * radius * std::cos(angle - 2 * pi / 3 * static_cast<double>(k));
  return 3;
}

/// Of the shorter way round the circle.
double distance(double phi, double other) { return std::remainder(phi - other, 2 * pi); }

/// Over its peak: exp(-d^2/2 width^2).
double kernel(double phi, double centre, double width) {
  return std::exp(-0.5 * square(distance(phi, centre) / width));
}

}  // namespace

MarschnerCircle::MarschnerCircle(double eta, double fiber_eta, double theta_d)
    : eta_prime_(bravais_index(std::max(eta, smallest_index), theta_d)),
      eta_other_(square(std::max(eta, smallest_index)) / eta_prime_),
      c_(std::asin(1 / eta_prime_)),
      inverse_cos_theta_t_(1 / std::sqrt(1 - square(std::sin(theta_d) / fiber_eta))) {}

double MarschnerCircle::cubic(int p, double gamma) const {
  return gamma * ((6 * p * c_ / pi - 2) - 8 * p * c_ / (pi * pi * pi) * gamma * gamma);
}

double MarschnerCircle::cubic_rate(int p, double gamma) const {
  return (6 * p * c_ / pi - 2) - 24 * p * c_ / (pi * pi * pi) * gamma * gamma;
}

double MarschnerCircle::exact(int p, double gamma) const {
  return 2 * p * std::asin(std::sin(gamma) / eta_prime_) - 2 * gamma;
}

double MarschnerCircle::attenuation(int p, double gamma) const {
  const double entering = two_index_fresnel(eta_prime_, eta_other_, std::cos(gamma));
  if (p == 0) return entering;
  const double sin_t = std::sin(gamma) / eta_prime_;
  const double leaving = two_index_fresnel(1 / eta_prime_, 1 / eta_other_, std::sqrt(1 - sin_t * sin_t));
  return square(1 - entering) * (p == 1 ? 1 : leaving);
}

double MarschnerCircle::length(int p, double gamma) const {
  const double sin_t = std::sin(gamma) / eta_prime_;
  return 2 * p * std::sqrt(1 - sin_t * sin_t) * inverse_cos_theta_t_;
}

MarschnerPaths MarschnerCircle::paths(int p, double phi) const {
  MarschnerPaths found;
  const double linear = 6 * p * c_ / pi - 2, third = -8 * p * c_ / (pi * pi * pi);
  // phi = cubic + p pi: of the turns of phi - p pi those that the cubic can reach, which stays within 3.5 of 0.
  for (int turn = -1; turn <= 1; ++turn) {
    const double wanted = distance(phi, p * pi) + 2 * pi * turn;
    if (std::abs(wanted) > 3.5) continue;
    std::array<double, 3> root{};
    std::size_t count = 1;
    if (p == 0) {
      root[0] = -0.5 * wanted;
    } else {
      count = roots_of(third, linear, wanted, root);
    }
    for (std::size_t k = 0; k < count; ++k) {
      const double gamma = root[k];
      if (!(std::abs(gamma) <= 0.5 * pi) || found.count == found.path.size()) continue;
      const double rate = std::max(std::abs(cubic_rate(p, gamma)), smallest_rate);
      found.path[found.count++] = {0.5 * std::cos(gamma) / rate, attenuation(p, gamma), length(p, gamma),
                                   std::cos(gamma)};
    }
  }
  return found;
}

double MarschnerCircle::caustic_offset() const { return std::sqrt(std::max((4 - eta_prime_ * eta_prime_) / 3, 0.0)); }

MarschnerGlint MarschnerCircle::glint(const MarschnerCaustics& caustics) const {
  MarschnerGlint glint;
  const double linear = 12 * c_ / pi - 2, third = 16 * c_ / (pi * pi * pi);
  double gamma = std::asin(std::min(caustic_offset(), 1.0));
  if (eta_prime_ < 2) {
    const double turning = std::sqrt(std::max(linear, 0.0) / (3 * third));
    // d^2 phi/dh^2 at the turning point, where dphi/dgamma is 0.
    const double bend = 6 * third * turning / square(std::cos(turning));
    glint.azimuth = std::abs(distance(cubic(2, turning), 0));
    glint.strength = 1;
    glint.share = caustics.largest_share;
    if (bend > 0) glint.share = std::min(glint.share, 2 * std::sqrt(2 * caustics.width / bend));
  } else {
    gamma = 0;
    const double x = std::min((eta_prime_ - 2) / caustics.fade_range, 1.0);
    glint.strength = 1 - x * x * (3 - 2 * x);
    glint.share = caustics.largest_share;
  }
  glint.attenuation = attenuation(2, gamma);
  glint.length = length(2, gamma);
  return glint;
}

double MarschnerGlint::density(double phi, double width) const {
  const double peak = strength * share / (std::sqrt(2 * pi) * width);
  return peak * (kernel(phi, azimuth, width) + kernel(phi, -azimuth, width));
}

double MarschnerGlint::removal(double phi, double width) const {
  if (strength <= 0) return 1;
  return (1 - strength * kernel(phi, azimuth, width)) * (1 - strength * kernel(phi, -azimuth, width));
}

double marschner_index(double eta, double eccentricity, double phi_h) {
  if (eccentricity >= 1) return eta;
  const double a2 = eccentricity * eccentricity;
  const double first = 2 * (eta - 1) * a2 - eta + 2, second = 2 * (eta - 1) / a2 - eta + 2;
  return std::max(0.5 * (first + second + std::cos(2 * phi_h) * (first - second)), smallest_index);
}

MarschnerCircle marschner_trt_circle(double eta, double eccentricity, double phi_r, double theta_d, double phi) {
  return {marschner_index(eta, eccentricity, phi_r + 0.5 * phi), eta, theta_d};
}

}  // namespace tress::inline v0_2::fiber
