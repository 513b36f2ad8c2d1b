// The traced smooth circle against Maxwell's equations: the series of a dielectric cylinder in a plane wave at right
// angles (Mie's for cylinders; van de Hulst 1957, 15.3), and its terms by the number of inner reflections (Debye's
// series), in which orders do not interfere and light that passes the cylinder is left out. A hair of radius 40 um in
// light of 550 nm has the size 457, its circumference in wavelengths.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include "fiber/cross_section.h"

namespace tress {
namespace {

using Complex = std::complex<double>;

constexpr double pi = std::numbers::pi, eta = 1.55, hair = 457;
constexpr std::size_t orders = 4, bins = 36;  // of |azimuth| from straight on, 5 degrees
using Energies = std::array<double, orders>;
using Bins = std::array<std::array<double, bins>, orders>;

/// Outgoing cylindrical waves J_n + i Y_n and their derivatives, n = 0..count - 1.
struct Waves {
  std::vector<Complex> value, slope;

  Waves(double x, std::size_t count) : value(count), slope(count) {
    // J by recurrence from above, scaled by J_0 + 2 (J_2 + J_4 + ...) = 1, Y from below.
    const std::size_t top = 2 * (static_cast<std::size_t>(std::max(x, static_cast<double>(count))) / 2) + 120;
    std::vector<double> j(top + 2);
    j[top] = 1e-300;
    double sum = 0;
    for (std::size_t n = top; n > 0; --n) {
      j[n - 1] = 2 * static_cast<double>(n) / x * j[n] - j[n + 1];
      if (std::abs(j[n - 1]) > 1e200) {
        for (std::size_t k = n - 1; k <= top; ++k) j[k] *= 1e-200;
        sum *= 1e-200;
      }
      if (n % 2 == 1) sum += n == 1 ? j[0] : 2 * j[n - 1];
    }
    double before = std::cyl_neumann(0.0, x), y = std::cyl_neumann(1.0, x);
    for (std::size_t n = 0; n < count; ++n) {
      const double now = n == 0 ? before : y;
      value[n] = {j[n] / sum, now};
      if (n > 0) {
        const double next = 2 * static_cast<double>(n) / x * y - before;
        before = y;
        y = next;
      }
    }
    slope[0] = -value[1];
    for (std::size_t n = 1; n < count; ++n) slope[n] = value[n - 1] - static_cast<double>(n) / x * value[n];
  }
};

/// The amplitudes of the partial waves that leave: of order p in `of_order`, of all with the light that passes in
/// `all`, and the same from the endless sum of all orders in `summed`.
struct Series {
  double x;
  std::vector<Complex> all, summed;
  std::array<std::vector<Complex>, orders> of_order;

  /// along: whether the electric field is along the fiber.
  Series(double size, bool along) : x(size) {
    const auto count = static_cast<std::size_t>(size + 6 * std::cbrt(size) + 10);
    const Waves out(size, count), in(eta * size, count);
    const double ratio = along ? eta : 1 / eta;  // of the slopes inside and outside
    for (std::size_t n = 0; n < count; ++n) {
      const Complex h = out.value[n], dh = out.slope[n], g = in.value[n], dg = in.slope[n];
      all.push_back((g.real() * dh.real() - ratio * dg.real() * h.real()) / (g.real() * dh - ratio * dg.real() * h));
      const Complex coming = std::conj(h), dcoming = std::conj(dh), inwards = std::conj(g), dinwards = std::conj(dg);
      const Complex common = ratio * h * dinwards - dh * inwards;
      const Complex reflected = -(ratio * coming * dinwards - dcoming * inwards) / common,
                    entered = (coming + reflected * h) / inwards, inner = -(ratio * h * dg - dh * g) / common,
                    left = (g + inner * inwards) / h;
      summed.push_back(0.5 * (1.0 - reflected - entered * left / (1.0 - inner)));
      // What an offset beyond the radius does not meet is not reflected.
      of_order[0].push_back(static_cast<double>(n) < size ? -0.5 * reflected : Complex{});
      Complex inside = -0.5 * entered;
      for (std::size_t p = 1; p < orders; ++p, inside *= inner) of_order[p].push_back(inside * left);
    }
  }
  /// Shares of the light that falls on the fiber.
  static double energy(const std::vector<Complex>& amplitude, double x) {
    double sum = 0;
    for (std::size_t n = 0; n < amplitude.size(); ++n) sum += (n == 0 ? 1 : 2) * std::norm(amplitude[n]);
    return 2 / x * sum;
  }
  static std::array<double, bins> binned(const std::vector<Complex>& amplitude, double x) {
    constexpr std::size_t each = 40;
    std::array<double, bins> shares{};
    for (std::size_t i = 0; i < bins * each; ++i) {
      const double phi = pi * (static_cast<double>(i) + 0.5) / (bins * each), twice = 2 * std::cos(phi);
      double before = std::cos(phi), now = 1;  // cos((n - 1) phi), cos(n phi)
      Complex sum = amplitude[0];
      for (std::size_t n = 1; n < amplitude.size(); ++n) {
        const double next = twice * now - before;
        before = now;
        now = next;
        sum += 2 * now * amplitude[n];
      }
      shares[i / each] += 2 * std::norm(sum) / (pi * x) * pi / (bins * each);
    }
    return shares;
  }
};

/// Fresnel's reflectances of a ray that meets the circle at an offset, the field along the fiber and across it.
std::array<double, 2> reflectances(double h) {
  const double out = std::sqrt(1 - h * h), in = std::sqrt(1 - h * h / (eta * eta));
  const double s = (out - eta * in) / (out + eta * in), p = (eta * out - in) / (eta * out + in);
  return {s * s, p * p};
}
double share(std::size_t order, double f) {
  return order == 0 ? f : (1 - f) * (1 - f) * std::pow(f, static_cast<double>(order) - 1);
}
double of_both(std::size_t order, double h) {
  const auto [s, p] = reflectances(h);
  return 0.5 * (share(order, s) + share(order, p));
}

/// What the tracer's rays carry by order and bin: polarised light, if both polarisations are traced by Fresnel's terms
/// of their own, and the tracer's own, which is unpolarised again after every event.
struct Rays {
  Bins polarised{}, unpolarised{};
  double largest_difference = 0;  ///< of the tracer's weights from Fresnel's terms

  Rays() {
    const fiber::CrossSection section(eta, 1, 0, 0);
    constexpr int count = 100000;
    for (int i = 0; i < count; ++i) {
      const double h = (i + 0.5) / count;  // both sides are alike
      const auto [s, p] = reflectances(h);
      double left;
      section.follow(h, 3, 0, &left, [&](int k, double weight, double x, double y, double) {
        const auto order = static_cast<std::size_t>(k);
        const double from_straight = std::abs(std::atan2(y, -x));  // light comes from azimuth 0
        const auto bin = std::min(static_cast<std::size_t>(from_straight / pi * bins), bins - 1);
        polarised[order][bin] += of_both(order, h) / count;
        unpolarised[order][bin] += weight / count;
        largest_difference = std::max(largest_difference, std::abs(weight - share(order, 0.5 * (s + p))));
      });
    }
  }
};

double total(const std::array<double, bins>& of) {
  double sum = 0;
  for (const double one : of) sum += one;
  return sum;
}

/// What rays get wrong by the edge, where x^(1/3) partial waves are neither in nor out: light of the offsets within
/// two widths x^(-2/3) of it, and as much that tunnels in from beyond.
double edge(std::size_t order, double x) {
  const double width = 2 * std::pow(x, -2.0 / 3);
  constexpr int points = 2000;
  double sum = 0;
  for (int i = 0; i < points; ++i) sum += of_both(order, 1 - width * (i + 0.5) / points) * width / points;
  return 2 * sum;
}

TEST(WaveOptics, SeriesLosesNoLightAndIsTheSumOfItsOrders) {
  for (const bool along : {true, false}) {
    const Series series(hair, along);
    for (std::size_t n = 0; n < series.all.size(); ++n) {
      EXPECT_NEAR(std::abs(1.0 - 2.0 * series.all[n]), 1, 1e-9) << n;
      EXPECT_NEAR(std::abs(series.summed[n] - series.all[n]), 0, 1e-9) << n;
    }
    EXPECT_NEAR(Series::energy(series.all, hair), 2, 0.2) << "what is scattered, and as much that is missing behind";
  }
}

TEST(WaveOptics, RaysHaveTheEnergiesAndAzimuthsOfMaxwellsEquations) {
  const Rays rays;
  EXPECT_LT(rays.largest_difference, 1e-9) << "Fresnel's terms of unpolarised light";
  constexpr int sizes = 6;  // a band of sizes smooths the fringes of each order
  Bins waves{};
  for (int i = 0; i < sizes; ++i)
    for (const bool along : {true, false}) {
      const Series series(430 + 11 * i, along);
      for (std::size_t p = 0; p < orders; ++p) {
        const auto binned = Series::binned(series.of_order[p], series.x);
        for (std::size_t b = 0; b < bins; ++b) waves[p][b] += binned[b] / (2 * sizes);
      }
    }
  for (std::size_t p = 0; p < orders; ++p) {
    double apart = 0;
    for (std::size_t b = 0; b < bins; ++b) apart += std::abs(waves[p][b] - rays.polarised[p][b]);
    const double energy = total(waves[p]), polarised = total(rays.polarised[p]), traced = total(rays.unpolarised[p]);
    std::printf("order %zu: waves %.5f, rays %.5f, traced %.5f; bins apart %.5f, bound %.5f\n", p, energy, polarised,
                traced, apart, edge(p, hair));
    EXPECT_NEAR(energy, polarised, 0.5 * edge(p, hair)) << p;
    EXPECT_LT(apart, edge(p, hair)) << p;
    RecordProperty("traced_over_polarised_" + std::to_string(p), std::to_string(traced / polarised));
  }
}

// What is left between them falls as the fiber grows.
TEST(WaveOptics, ComesNearerToRaysOnWiderFibers) {
  for (std::size_t p = 1; p < orders; ++p) {
    double rays = 0;
    constexpr int points = 20000;
    for (int i = 0; i < points; ++i) rays += of_both(p, (i + 0.5) / points) / points;
    double before = 1;
    for (const double size : {57.1, 114.2, 228.4, 456.8}) {
      double waves = 0;
      for (const bool along : {true, false}) waves += 0.5 * Series::energy(Series(size, along).of_order[p], size);
      EXPECT_LT(std::abs(waves - rays), 0.7 * before) << p << " " << size;
      before = std::abs(waves - rays);
    }
  }
}

// All orders together, with their interference, averaged over 24 sizes, which leaves less than 0.001 of it. Light that
// passes the fiber is bent: the share 2/(pi x phi) by more than phi (Fraunhofer's slit), nearly all by less than 10
// degrees. Each order's error by the edge counts in a zone in proportion to the order's light there.
TEST(WaveOptics, WholeSeriesIsTheLightOfAllRays) {
  const Rays rays;
  constexpr int sizes = 24;
  std::array<double, bins> whole{};
  for (int i = 0; i < sizes; ++i)
    for (const bool along : {true, false}) {
      const Series series(453 + i / 3.0, along);
      const auto binned = Series::binned(series.all, series.x);
      for (std::size_t b = 0; b < bins; ++b) whole[b] += binned[b] / (2 * sizes);
    }
  const auto bent_beyond = [](std::size_t bin) { return 2 / (pi * hair * (static_cast<double>(bin) * pi / bins)); };
  for (const auto& [from, to] : {std::array<std::size_t, 2>{2, 12}, {12, 31}, {31, 36}}) {
    double waves = 0, expected = bent_beyond(from) - bent_beyond(to), bound = 0.001;
    for (std::size_t p = 0; p < orders; ++p) {
      double in_zone = 0;
      for (std::size_t b = from; b < to; ++b) in_zone += rays.polarised[p][b];
      expected += in_zone;
      bound += 0.5 * edge(p, hair) * in_zone / total(rays.polarised[p]);
    }
    for (std::size_t b = from; b < to; ++b) waves += whole[b];
    std::printf("%zu to %zu degrees: waves %.5f, rays %.5f, bound %.5f\n", 5 * from, 5 * to, waves, expected, bound);
    EXPECT_NEAR(waves, expected, bound) << from;
  }
}

}  // namespace
}  // namespace tress
