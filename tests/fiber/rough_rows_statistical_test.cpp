// The draws of rough rows against whole paths through the same fiber. Seeds are fixed; the chance that right code fails
// is said at the test.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>

#include "fiber/fiber3d_reference.h"
#include "fiber/rough_fiber.h"
#include "fiber/rough_rows.h"
#include "support/scale.h"
#include "support/seed.h"

namespace tress {
namespace {

using fiber::FiberDirection;
using fiber::FiberParameters;

constexpr std::size_t sigmas = 3, moments = 4;
constexpr glm::vec3 sigma{0.0f, 0.25f, 1.0f};
/// Energy, and the first moments of sin theta, cos phi and sin phi: [part][sigma_a][moment].
template <class T>
using ByPart = std::array<std::array<std::array<T, moments>, sigmas>, fiber::rough_parts>;

std::array<double, moments> moments_of(const FiberDirection& w) {
  return {1, std::sin(static_cast<double>(w.theta)), std::cos(static_cast<double>(w.phi)),
          std::sin(static_cast<double>(w.phi))};
}

ByPart<test::SampleMean> of_whole_paths(FiberParameters parameters, const FiberDirection& wr, int paths) {
  parameters.sigma_a = sigma;
  const fiber::RoughFiber rough(parameters);
  RandomStream random(test::seed(21));
  ByPart<test::SampleMean> means;
  for (int i = 0; i < paths; ++i) {
    const float h = 2 * (static_cast<float>(i) + random.next()) / static_cast<float>(paths) - 1;
    const std::array<float, 4> u{random.next(), random.next(), random.next(), random.next()};
    const fiber::RoughExit exit = rough.trace(rough.entry(wr, h), u, random);
    const auto of_direction = moments_of(exit.angles());
    for (std::size_t part = 0; part < fiber::rough_parts; ++part) {
      for (std::size_t s = 0; s < sigmas; ++s) {
        const double kept =
            fiber::rough_part(exit.order) == part ? static_cast<double>(exit.throughput[static_cast<int>(s)]) : 0;
        for (std::size_t m = 0; m < moments; ++m) means[part][s][m].add(kept * of_direction[m]);
      }
    }
  }
  return means;
}

/// A sample is the mean over one stream.
ByPart<test::SampleMean> of_rows(const FiberParameters& parameters, const FiberDirection& wr, int streams,
                                 std::uint32_t paths) {
  const auto slice = fiber::rough_slice(parameters);
  const fiber::RoughNode node = fiber::RoughGrid(slice).choose(wr, 0.5f, 0.5f);
  const auto target = fiber::make_rough_target();
  ByPart<test::SampleMean> means;
  std::vector<adaptive::SampledExit> exits;
  for (int stream = 0; stream < streams; ++stream) {
    exits.clear();
    target->draw(slice, slice.axis_a.at(node.a), slice.axis_b.at(node.b),
                 test::seed(100) + static_cast<std::uint64_t>(stream), 0, paths, exits);
    ByPart<double> sum{};
    for (const adaptive::SampledExit& exit : exits) {
      const auto of_direction = moments_of({node.theta(exit.height, wr.theta), node.phi(exit.azimuth, wr.phi)});
      for (std::size_t s = 0; s < sigmas; ++s) {
        const double kept = static_cast<double>(exit.weight) *
                            std::exp(-static_cast<double>(sigma[static_cast<int>(s)] * exit.attribute));
        for (std::size_t m = 0; m < moments; ++m) sum[exit.part][s][m] += kept * of_direction[m];
      }
    }
    for (std::size_t part = 0; part < fiber::rough_parts; ++part) {
      for (std::size_t s = 0; s < sigmas; ++s) {
        for (std::size_t m = 0; m < moments; ++m) means[part][s][m].add(sum[part][s][m] / paths);
      }
    }
  }
  return means;
}

// At nodes, in quadrants that are folded: energies and first moments by part, clear and absorbed, agree within 5
// standard errors of both. 480 comparisons at 10 configurations: 4e-4 with 64 streams, whose spread is a t law's.
TEST(rough_rows_statistics, draws_are_what_whole_paths_give) {
  struct Cell {
    float eccentricity, alpha, tilt_deg, theta_deg, phi_deg;
    fiber::TracedParts parts{};
  };
  constexpr float degree = std::numbers::pi_v<float> / 180;
  double largest = 0;
  for (const Cell& cell :
       {Cell{0.85f, 0.2f, 3, 30, 45}, Cell{0.5f, 0.1f, 0, -60, 172.5f}, Cell{1, 0.3f, 3, -80, 30},
        Cell{0.75f, 0.05f, 3, 0, -97.5f}, Cell{0.6f, 0.3f, 0, -80, -45}, Cell{0.85f, 0.02f, 5, -60, 7.5f},
        Cell{0.9f, 0.2f, 0, -30, 172.5f, {0.7f, 4, 0.4f, 0}}, Cell{0.7f, 0.1f, 3, 40, 30, {0.5f, 20, -0.3f, 1}},
        Cell{0.8f, 0.2f, 3, 30, 45, {0, 0, 0, 0, 1.5f, 0.2f}}, Cell{0.8f, 0.2f, 3, 30, 45, {0, 0, 0, 0, 0, 0, 1}}}) {
    FiberParameters parameters;
    parameters.eccentricity = cell.eccentricity;
    parameters.roughness = cell.alpha;
    parameters.tilt = cell.tilt_deg * degree;
    cell.parts.give_to(parameters);
    const FiberDirection wr{cell.theta_deg * degree, cell.phi_deg * degree};
    const auto whole = of_whole_paths(parameters, wr, test::scaled(200000));
    const auto rows = of_rows(parameters, wr, 64, static_cast<std::uint32_t>(test::scaled(1024)));
    for (std::size_t part = 0; part < fiber::rough_parts; ++part) {
      for (std::size_t s = 0; s < sigmas; ++s) {
        for (std::size_t m = 0; m < moments; ++m) {
          const auto &x = whole[part][s][m], &y = rows[part][s][m];
          const double error = std::hypot(x.standard_error(), y.standard_error());
          if (error > 0) largest = std::max(largest, std::abs(x.mean() - y.mean()) / error);
          EXPECT_NEAR(x.mean(), y.mean(), 5 * error + 1e-6)
              << "e " << cell.eccentricity << " alpha " << cell.alpha << " theta " << cell.theta_deg << " part " << part
              << " sigma_a " << sigma[static_cast<int>(s)] << " moment " << m;
        }
      }
    }
    std::printf(
        "e %.2f alpha %.2f theta %3.0f: energies %.4f %.4f %.4f %.4f, errors %.5f of whole paths, %.5f of rows\n",
        static_cast<double>(cell.eccentricity), static_cast<double>(cell.alpha), static_cast<double>(cell.theta_deg),
        rows[0][0][0].mean(), rows[1][0][0].mean(), rows[2][0][0].mean(), rows[3][0][0].mean(),
        whole[1][0][0].standard_error(), rows[1][0][0].standard_error());
  }
  std::printf("largest deviation: %.2f standard errors\n", largest);
}

}  // namespace
}  // namespace tress
