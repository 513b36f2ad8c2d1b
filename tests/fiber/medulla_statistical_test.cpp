// The medulla, a cortex that scatters and water against closed forms, their furnace and a tracer of other code. Seeds
// are fixed; the chance that right code fails is said at each test.
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

/// The same with a cortex that scatters instead of a medulla.
FiberParameters unbounded_cortex(float scattering, float asymmetry) {
  FiberParameters fiber = unbounded(0, 0, 0, 0);
  fiber.cortex_scattering = scattering;
  fiber.cortex_asymmetry = asymmetry;
  return fiber;
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

// The whole fiber scatters: 4 comparisons, as above (4e-6 of each).
TEST(medulla_statistics, light_that_meets_nothing_in_the_cortex_goes_straight_on) {
  for (const float theta : {0.0f, 1.0f}) {
    for (const float scattering : {0.7f, 3.0f}) {
      test::SampleMean straight;
      trace(unbounded_cortex(scattering, 0.2f), {theta, 0.6f}, test::scaled(200000), 41,
            [&](const fiber::RoughExit& exit, const fiber::RoughEntry& entry) {
              straight.add(glm::dot(exit.direction, entry.direction) < -0.9999f ? 1 : 0);
            });
      EXPECT_NEAR(straight.mean(), through_the_core(1, theta, scattering), 5 * straight.standard_error() + 3e-4)
          << theta << ' ' << scattering;
    }
  }
}

// Light that is turned by nothing goes on as if it had met nothing, however often it scatters: the same direction and
// way, but for rounding, of each path between two surfaces that do next to nothing.
TEST(medulla_statistics, scattering_straight_ahead_is_no_scattering) {
  std::array<test::SampleMean, 2> way, straight;
  for (const bool scatters : {false, true}) {
    trace(unbounded_cortex(scatters ? 5 : 0, 1), {0.4f, 0.6f}, 20000, 42,
          [&](const fiber::RoughExit& exit, const fiber::RoughEntry& entry) {
            straight[scatters].add(glm::dot(exit.direction, entry.direction) < -0.999f ? 1 : 0);
            way[scatters].add(exit.order == 1 ? static_cast<double>(exit.way) : 0);
          });
  }
  EXPECT_NEAR(straight[1].mean(), straight[0].mean(), 5 * std::hypot(straight[0].standard_error(), 1e-4));
  EXPECT_NEAR(way[1].mean(), way[0].mean(), 5 * std::hypot(way[0].standard_error(), way[1].standard_error()));
}

// In a round fiber lit from all sides the mean way of light is that of a convex body, 4 V/S = 2 semi-axes, times eta^2,
// whatever its surface is, whether water covers it and whatever scatters inside, if no light is lost and all of it is
// reciprocal: then there is eta^2 times as much light inside as outside. The theta of light that falls evenly on a
// cylinder's side has the density cos^2 theta. 5 standard errors (5 comparisons: 3e-6).
TEST(medulla_statistics, the_mean_way_of_light_from_all_sides_is_that_of_any_lossless_body) {
  for (const fiber::TracedParts& parts :
       {fiber::TracedParts{}, fiber::TracedParts{0, 0, 0, 0, 2, 0.3f}, fiber::TracedParts{0, 0, 0, 0, 0, 0, 1},
        fiber::TracedParts{0, 0, 0, 0, 1, 0.3f, 1}, fiber::TracedParts{0, 0, 0, 0, 1, -0.3f, 0.5f}}) {
    FiberParameters parameters;
    parameters.eccentricity = 1;
    parameters.roughness = 0.3f;
    parameters.tilt = 0;
    parameters.sigma_a = glm::vec3(0.0f);
    parts.give_to(parameters);
    const RoughFiber rough(parameters);
    RandomStream random(test::seed(43));
    test::SampleMean way;
    for (int i = 0; i < test::scaled(100000); ++i) {
      float theta = 0;
      do {
        theta = static_cast<float>(pi) * (random.next() - 0.5f);
      } while (random.next() > std::cos(theta) * std::cos(theta));
      const std::array<float, 4> u{random.next(), random.next(), random.next(), random.next()};
      way.add(static_cast<double>(rough.trace(rough.entry({theta, 0.6f}, 2 * random.next() - 1), u, random).way));
    }
    EXPECT_NEAR(way.mean(), 2 * 1.55 * 1.55, 5 * way.standard_error())
        << parts.cortex_scattering << ' ' << parts.wetness;
    std::printf("scattering %.0f, wetness %.1f: mean way %.4f +- %.4f, 2 eta^2 %.4f\n",
                static_cast<double>(parts.cortex_scattering), static_cast<double>(parts.wetness), way.mean(),
                way.standard_error(), 2 * 1.55 * 1.55);
  }
}

/// Unpolarised reflectance between two indices.
double reflectance(double n1, double n2, double sine_in_air) {
  const double c1 = std::sqrt(1 - std::pow(sine_in_air / n1, 2)), c2 = std::sqrt(1 - std::pow(sine_in_air / n2, 2));
  const double s = (n1 * c1 - n2 * c2) / (n1 * c1 + n2 * c2), p = (n2 * c1 - n1 * c2) / (n2 * c1 + n1 * c2);
  return (s * s + p * p) / 2;
}

// A smooth fiber in the middle of its width, inclined by theta: what is reflected is the series of two plates, R1 +
// T1^2 R2/(1 - R1 R2), by the covered share. 5 standard errors (6 comparisons: 4e-6); 3e-4 for a roughness of 1e-4.
TEST(medulla_statistics, a_film_of_water_reflects_as_two_plates) {
  for (const float theta : {0.0f, 1.0f, 1.4f}) {
    const double sine = std::sin(theta), first = reflectance(1, 1.33, sine), second = reflectance(1.33, 1.55, sine);
    const double wet = first + (1 - first) * (1 - first) * second / (1 - first * second);
    for (const float wetness : {1.0f, 0.3f}) {
      FiberParameters fiber = unbounded(0, 0, 0, 0);
      fiber.eta = 1.55f;
      fiber.wetness = wetness;
      const RoughFiber rough(fiber);
      RandomStream random(test::seed(44));
      test::SampleMean reflected;
      for (int i = 0; i < test::scaled(200000); ++i) {
        const std::array<float, 4> u{random.next(), random.next(), random.next(), random.next()};
        reflected.add(rough.trace(rough.entry({theta, 0.6f}, 0), u, random).order == 0 ? 1 : 0);
      }
      const double expected = wetness * wet + (1 - wetness) * reflectance(1, 1.55, sine);
      EXPECT_NEAR(reflected.mean(), expected, 5 * reflected.standard_error() + 3e-4) << theta << ' ' << wetness;
    }
  }
}

// Every path of a clear, half wet fiber with a core that only scatters gives back what it brought.
TEST(medulla_statistics, a_core_that_only_scatters_loses_nothing) {
  for (const float scattering : {0.0f, 1.0f, 20.0f, 100.0f}) {
    for (const float asymmetry : {-0.9f, 0.0f, 0.95f}) {
      FiberParameters fiber = unbounded(0.8f, scattering, asymmetry, 0);
      fiber.eta = 1.55f;
      fiber.eccentricity = 0.7f;
      fiber.roughness = 0.2f;
      fiber.tilt = 0.05f;
      fiber.cortex_scattering = 0.2f * scattering;
      fiber.cortex_asymmetry = -0.5f * asymmetry;
      fiber.wetness = 0.5f;
      trace(fiber, {-1.2f, 0.6f}, 1000, 33, [&](const fiber::RoughExit& exit, const auto&) {
        EXPECT_FLOAT_EQ(exit.throughput.g, 1) << scattering << ' ' << asymmetry << ' ' << exit.order;
        EXPECT_NEAR(glm::length(exit.direction), 1, 1e-4f);
      });
    }
  }
}

TEST(medulla_statistics, without_a_radius_and_cortex_scattering_nothing_else_matters) {
  FiberParameters none;
  FiberParameters fiber = none;
  fiber.medulla_scattering = 3;
  fiber.medulla_asymmetry = 0.5f;
  fiber.medulla_absorption = 2;
  fiber.cortex_asymmetry = 0.3f;
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
    const double pigment = fiber_.sigma_a.g, cortex = pigment + fiber_.cortex_scattering,
                 majorant = std::max(core, cortex);
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
        if (u < cortex) turn(d, fiber_.cortex_asymmetry);
      } else if (u < scattering) {
        turn(d, fiber_.medulla_asymmetry);
      } else if (u < core) {
        return false;
      }
    }
  }

  /// Henyey and Greenstein's law by rejection: a direction of the sphere, kept by its phase function.
  void turn(Vec& d, double g) {
    const double most = std::pow(1 - std::abs(g), -3);
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

// Energies and moments of direction by order of nearly smooth fibers, 5 standard errors of both (175 comparisons:
// 1e-4), and 3e-4 for a roughness of 1e-4.
TEST(medulla_statistics, another_tracer_finds_the_same) {
  struct Cell {
    float eccentricity, eta, theta, radius, scattering, asymmetry, absorption, sigma_a;
    float cortex_scattering = 0, cortex_asymmetry = 0;
  };
  const int paths = test::scaled(300000);
  double largest = 0;
  for (const Cell& cell :
       {Cell{1, 1.05f, 0, 0.7f, 2, 0, 0, 0.1f}, Cell{0.8f, 1.55f, 0.5f, 0.8f, 3, 0.5f, 0.4f, 0.3f},
        Cell{0.5f, 1.3f, -1.1f, 0.5f, 10, -0.4f, 0, 0.2f}, Cell{0.9f, 1.55f, 0.2f, 0.95f, 1, 0.8f, 0.2f, 0.05f},
        Cell{0.7f, 1.55f, 0, 0.3f, 30, 0, 1, 0.5f}, Cell{0.8f, 1.55f, 0.4f, 0, 0, 0, 0, 0.2f, 1.5f, 0.3f},
        Cell{1, 1.55f, -0.9f, 0.6f, 4, 0.5f, 0.2f, 0.3f, 0.7f, -0.4f}}) {
    FiberParameters fiber = unbounded(cell.radius, cell.scattering, cell.asymmetry, cell.absorption);
    fiber.cortex_scattering = cell.cortex_scattering;
    fiber.cortex_asymmetry = cell.cortex_asymmetry;
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
