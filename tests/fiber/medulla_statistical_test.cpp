// The medulla against closed forms, against its furnace and against a tracer of other code. Seeds are fixed; the chance
// that right code fails is said at each test.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

#include "fiber/clear_energies.h"
#include "fiber/fiber3d_reference.h"
#include "fiber/rough_fiber.h"
#include "support/scale.h"
#include "support/seed.h"

namespace tress {
namespace {

using fiber::FiberDirection;
using fiber::FiberParameters;
using fiber::RoughFiber;

constexpr double pi = std::numbers::pi;

/// Surfaces that do next to nothing: the index of air but for 1e-4.
FiberParameters unbounded(float radius, float scattering, float asymmetry, float absorption) {
  FiberParameters fiber;
  fiber.eta = 1.0001f;
  fiber.eccentricity = 1;
  fiber.roughness = 1e-4f;
  fiber.tilt = 0;
  fiber.sigma_a = glm::vec3(0.0f);
  fiber.medulla_radius = radius;
  fiber.medulla_scattering = scattering;
  fiber.medulla_asymmetry = asymmetry;
  fiber.medulla_absorption = absorption;
  return fiber;
}

/// Calls visit(exit, entry) for `paths` paths stratified in h.
template <class Visit>
void trace(const FiberParameters& parameters, const FiberDirection& wr, int paths, std::uint64_t seed, Visit&& visit) {
  const RoughFiber rough(parameters);
  RandomStream random(test::seed(seed));
  for (int i = 0; i < paths; ++i) {
    const float h = 2 * (static_cast<float>(i) + random.next()) / static_cast<float>(paths) - 1;
    const std::array<float, 4> u{random.next(), random.next(), random.next(), random.next()};
    const auto entry = rough.entry(wr, h);
    visit(rough.trace(entry, u, random), entry);
  }
}

/// The mean over offsets of exp(-coefficient chord), chord that of a core of a round fiber.
double through_the_core(double radius, double theta, double coefficient) {
  constexpr int n = 1 << 16;
  double sum = 0;
  for (int i = 0; i < n; ++i) {
    const double h = (2 * i + 1.0) / n - 1;
    sum += std::exp(-coefficient * 2 * std::sqrt(std::max(radius * radius - h * h, 0.0)) / std::cos(theta)) / n;
  }
  return sum;
}

// Where surfaces do nothing, light that was not scattered goes straight on: exp(-(scattering + absorption) chord), over
// all offsets. 5 standard errors (12 of them: 7e-6), 3e-4 for the surfaces and for light scattered by so little.
TEST(medulla_statistics, light_that_meets_nothing_goes_straight_on) {
  for (const auto& [radius, theta] : {std::pair{0.5f, 0.0f}, std::pair{0.9f, 1.0f}}) {
    for (const float scattering : {0.0f, 0.7f, 3.0f}) {
      for (const float absorption : {0.0f, 0.5f}) {
        test::SampleMean straight;
        trace(unbounded(radius, scattering, 0.2f, absorption), {theta, 0.6f}, test::scaled(200000), 31,
              [&](const fiber::RoughExit& exit, const fiber::RoughEntry& entry) {
                const bool is = glm::dot(exit.direction, entry.direction) < -0.9999f;
                straight.add(is ? static_cast<double>(exit.throughput.g) : 0);
              });
        EXPECT_NEAR(straight.mean(), through_the_core(radius, theta, scattering + absorption),
                    5 * straight.standard_error() + 3e-4)
            << radius << ' ' << scattering << ' ' << absorption;
      }
    }
  }
}

// Pigment is in the cortex only: a core that does nothing takes its chord out of the way. 5 standard errors, 3e-4 for
// the surfaces.
TEST(medulla_statistics, pigment_colors_the_way_in_the_cortex) {
  FiberParameters fiber = unbounded(0.6f, 0, 0, 0);
  fiber.sigma_a = glm::vec3(0.8f);
  test::SampleMean kept;
  trace(fiber, {0.5f, 0.6f}, 100000, 32, [&](const fiber::RoughExit& exit, const auto&) {
    kept.add(exit.order == 1 ? static_cast<double>(exit.throughput.g) : 0);
  });
  double expected = 0;
  constexpr int n = 1 << 16;
  for (int i = 0; i < n; ++i) {
    const double h = (2 * i + 1.0) / n - 1;
    const double chord = 2 * (std::sqrt(1 - h * h) - std::sqrt(std::max(0.36 - h * h, 0.0)));
    expected += std::exp(-0.8 * chord / std::cos(0.5)) / n;
  }
  EXPECT_NEAR(kept.mean(), expected, 5 * kept.standard_error() + 3e-4);
}

// Every path of a clear fiber with a core that only scatters gives back what it brought.
TEST(medulla_statistics, a_core_that_only_scatters_loses_nothing) {
  for (const float scattering : {0.0f, 1.0f, 20.0f, 100.0f}) {
    for (const float asymmetry : {-0.9f, 0.0f, 0.95f}) {
      FiberParameters fiber = unbounded(0.8f, scattering, asymmetry, 0);
      fiber.eta = 1.55f;
      fiber.eccentricity = 0.7f;
      fiber.roughness = 0.2f;
      fiber.tilt = 0.05f;
      trace(fiber, {-1.2f, 0.6f}, 1000, 33, [&](const fiber::RoughExit& exit, const auto&) {
        EXPECT_FLOAT_EQ(exit.throughput.g, 1) << scattering << ' ' << asymmetry << ' ' << exit.order;
        EXPECT_NEAR(glm::length(exit.direction), 1, 1e-4f);
      });
    }
  }
}

TEST(medulla_statistics, without_a_radius_nothing_else_matters) {
  FiberParameters none;
  FiberParameters fiber = none;
  fiber.medulla_scattering = 3;
  fiber.medulla_asymmetry = 0.5f;
  fiber.medulla_absorption = 2;
  std::vector<glm::vec3> with, without;
  const auto into = [](std::vector<glm::vec3>& out) {
    return [&out](const fiber::RoughExit& exit, const auto&) {
      out.push_back(exit.direction);
      out.push_back(exit.throughput);
    };
  };
  trace(none, {0.3f, 0.6f}, 1000, 34, into(without));
  trace(fiber, {0.3f, 0.6f}, 1000, 34, into(with));
  EXPECT_EQ(with, without);
  EXPECT_EQ(fiber::energy_key(fiber), fiber::energy_key(none));
}

constexpr std::size_t orders = 5, moments = 5;
/// Energy, and the first moments of sin theta, cos phi, sin phi and sin^2 theta by order, 4 and later together.
using ByOrder = std::array<std::array<test::SampleMean, moments>, orders>;

void add(ByOrder& means, int order, double weight, const std::array<double, 3>& direction) {
  const double cosine = std::hypot(direction[1], direction[2]);
  const std::array<double, moments> values{1, direction[0], direction[1] / cosine, direction[2] / cosine,
                                           direction[0] * direction[0]};
  for (std::size_t p = 0; p < orders; ++p) {
    const bool its = p == std::min(static_cast<std::size_t>(order), orders - 1);
    for (std::size_t m = 0; m < moments; ++m) means[p][m].add(its ? weight * values[m] : 0);
  }
}

/// A smooth elliptical fiber with a core by delta tracking: tentative events of one majorant over the whole inside,
/// each a real one with the probability of what is there; absorption ends the path. Double precision; what it shares
/// with the library is the frame only.
class DeltaTracker {
 public:
  DeltaTracker(const FiberParameters& fiber, std::uint64_t seed) : fiber_(fiber), random_(seed) {}

  void trace(const FiberDirection& wr, double h, ByOrder& means) {
    const double e = fiber_.eccentricity, cos_phi = std::cos(wr.phi), sin_phi = std::sin(wr.phi);
    const double around = std::atan2(sin_phi, e * cos_phi) + std::asin(h);
    Vec at{0, std::cos(around), e * std::sin(around)};
    Vec d{-std::sin(wr.theta), -std::cos(wr.theta) * cos_phi, -std::cos(wr.theta) * sin_phi};
    bool inside = meet(at, d, false);
    int order = 0;
    while (inside) {
      ++order;
      if (!fly(at, d)) return add(means, 0, 0, {0, 1, 0});  // absorbed
      inside = meet(at, d, true);
    }
    add(means, order, 1, d);
  }

 private:
  using Vec = std::array<double, 3>;
  static double dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
  double uniform() { return std::uniform_real_distribution<double>()(random_); }

  /// Reflects or refracts at the surface; returns whether light is inside then.
  bool meet(const Vec& at, Vec& d, bool from_inside) {
    const double e = fiber_.eccentricity, eta = fiber_.eta;
    Vec n{0, at[1], at[2] / (e * e)};
    const double size = std::sqrt(dot(n, n)) * (from_inside ? -1 : 1);
    for (double& x : n) x /= size;
    const double cos_i = -dot(d, n), ratio = from_inside ? eta : 1 / eta;
    const double sin2_t = ratio * ratio * (1 - cos_i * cos_i);
    double reflected = 1;
    const double cos_t = std::sqrt(std::max(1 - sin2_t, 0.0));
    if (sin2_t < 1) {
      const double n1 = from_inside ? eta : 1, n2 = from_inside ? 1 : eta;
      const double s = (n1 * cos_i - n2 * cos_t) / (n1 * cos_i + n2 * cos_t);
      const double p = (n2 * cos_i - n1 * cos_t) / (n2 * cos_i + n1 * cos_t);
      reflected = (s * s + p * p) / 2;
    }
    if (uniform() < reflected) {
      for (std::size_t i = 0; i < 3; ++i) d[i] += 2 * cos_i * n[i];
      return from_inside;
    }
    for (std::size_t i = 0; i < 3; ++i) d[i] = ratio * d[i] + (ratio * cos_i - cos_t) * n[i];
    return !from_inside;
  }

  /// To the surface; false: absorbed on the way.
  bool fly(Vec& at, Vec& d) {
    const double e2 = static_cast<double>(fiber_.eccentricity) * fiber_.eccentricity, r = fiber_.medulla_radius;
    const double scattering = fiber_.medulla_scattering, core = scattering + fiber_.medulla_absorption;
    const double pigment = fiber_.sigma_a.g, majorant = std::max(core, pigment);
    for (;;) {
      const double step = -std::log(1 - uniform()) / majorant;
      const double a = d[1] * d[1] + d[2] * d[2] / e2, b = at[1] * d[1] + at[2] * d[2] / e2;
      const double c = at[1] * at[1] + at[2] * at[2] / e2 - 1;
      const double out = (-b + std::sqrt(std::max(b * b - a * c, 0.0))) / a;
      for (std::size_t i = 0; i < 3; ++i) at[i] += std::min(step, out) * d[i];
      if (step >= out) return true;
      const double u = uniform() * majorant;
      if (at[1] * at[1] + at[2] * at[2] / e2 > r * r) {
        if (u < pigment) return false;
      } else if (u < scattering) {
        turn(d);
      } else if (u < core) {
        return false;
      }
    }
  }

  /// Henyey and Greenstein's law by rejection: a direction of the sphere, kept by its phase function.
  void turn(Vec& d) {
    const double g = fiber_.medulla_asymmetry, most = std::pow(1 - std::abs(g), -3);
    for (;;) {
      const double x = 2 * uniform() - 1, phi = 2 * pi * uniform(), flat = std::sqrt(1 - x * x);
      const Vec w{x, flat * std::cos(phi), flat * std::sin(phi)};
      if (uniform() * most > std::pow(1 + g * g - 2 * g * dot(w, d), -1.5)) continue;
      d = w;
      return;
    }
  }

  FiberParameters fiber_;
  std::mt19937_64 random_;
};

// Energies and moments of direction by order of nearly smooth fibers, 5 standard errors of both (125 comparisons:
// 7e-5), and 3e-4 for a roughness of 1e-4.
TEST(medulla_statistics, another_tracer_finds_the_same) {
  struct Cell {
    float eccentricity, eta, theta, radius, scattering, asymmetry, absorption, sigma_a;
  };
  const int paths = test::scaled(300000);
  double largest = 0;
  for (const Cell& cell :
       {Cell{1, 1.05f, 0, 0.7f, 2, 0, 0, 0.1f}, Cell{0.8f, 1.55f, 0.5f, 0.8f, 3, 0.5f, 0.4f, 0.3f},
        Cell{0.5f, 1.3f, -1.1f, 0.5f, 10, -0.4f, 0, 0.2f}, Cell{0.9f, 1.55f, 0.2f, 0.95f, 1, 0.8f, 0.2f, 0.05f},
        Cell{0.7f, 1.55f, 0, 0.3f, 30, 0, 1, 0.5f}}) {
    FiberParameters fiber = unbounded(cell.radius, cell.scattering, cell.asymmetry, cell.absorption);
    fiber.eta = cell.eta;
    fiber.eccentricity = cell.eccentricity;
    fiber.sigma_a = glm::vec3(cell.sigma_a);
    const FiberDirection wr{cell.theta, 0.6f};
    ByOrder ours, theirs;
    trace(fiber, wr, paths, 35, [&](const fiber::RoughExit& exit, const auto&) {
      const glm::vec3& d = exit.direction;
      add(ours, exit.order, static_cast<double>(exit.throughput.g), {d.x, d.y, d.z});
    });
    DeltaTracker tracker(fiber, test::seed(36));
    for (int i = 0; i < paths; ++i) tracker.trace(wr, (2 * i + 1.0) / paths - 1, theirs);
    for (std::size_t p = 0; p < orders; ++p) {
      for (std::size_t m = 0; m < moments; ++m) {
        const auto &x = ours[p][m], &y = theirs[p][m];
        const double error = std::hypot(x.standard_error(), y.standard_error());
        largest = std::max(largest, std::abs(x.mean() - y.mean()) / (error + 1e-9));
        EXPECT_NEAR(x.mean(), y.mean(), 5 * error + 3e-4)
            << "e " << cell.eccentricity << " scattering " << cell.scattering << " order " << p << " moment " << m;
      }
    }
    std::printf("e %.2f scattering %4.1f: energies %.4f %.4f %.4f %.4f, theirs %.4f %.4f %.4f %.4f\n",
                static_cast<double>(cell.eccentricity), static_cast<double>(cell.scattering), ours[0][0].mean(),
                ours[1][0].mean(), ours[2][0].mean(), ours[3][0].mean(), theirs[0][0].mean(), theirs[1][0].mean(),
                theirs[2][0].mean(), theirs[3][0].mean());
  }
  std::printf("largest deviation: %.2f standard errors\n", largest);
}

// The tables of energies: what leaves is what whole paths keep, by lobe. Their standard error is 0.006 (ClearEnergies);
// bound: five times that.
TEST(medulla_statistics, tables_of_energies_have_it) {
  FiberParameters fiber = unbounded(0.7f, 4, 0.3f, 0.5f);
  fiber.eta = 1.55f;
  fiber.roughness = 0.2f;
  const fiber::ClearEnergies table(fiber::energy_key(fiber));
  for (const int node : {32 * fiber::ClearEnergies::azimuths, 50 * fiber::ClearEnergies::azimuths}) {
    std::array<test::SampleMean, 5> energy;
    trace(fiber, {fiber::ClearEnergies::theta_of(node), fiber::ClearEnergies::phi_of(node)}, test::scaled(100000), 37,
          [&](const fiber::RoughExit& exit, const auto&) {
            for (std::size_t p = 0; p < 5; ++p) {
              const bool its = p == std::min(static_cast<std::size_t>(exit.order), std::size_t{4});
              energy[p].add(its ? static_cast<double>(exit.throughput.g) : 0);
            }
          });
    for (std::size_t p = 0; p < 5; ++p) {
      EXPECT_NEAR(static_cast<double>(table.clear(node)[p]), energy[p].mean(), 0.03 * test::widened(100000)) << p;
    }
  }
}

}  // namespace
}  // namespace tress
