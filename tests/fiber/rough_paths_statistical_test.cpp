// Paths in lanes against RoughFiber::trace_split(), one after the other. Seeds are fixed; the chance that right code
// fails is said at the test.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

#include "base/sobol.h"
#include "fiber/fiber3d_reference.h"
#include "fiber/rough_paths.h"
#include "fiber/rough_rows.h"
#include "support/scale.h"
#include "support/seed.h"

namespace tress {
namespace {

using fiber::FiberDirection;
using fiber::FiberParameters;
using fiber::RoughFiber;

constexpr float degree = std::numbers::pi_v<float> / 180;
constexpr fiber::SplitRules rules{0.25f, std::numeric_limits<float>::infinity()};

struct Cell {
  float eccentricity, alpha, theta_deg, tilt_deg, eta;
  fiber::TracedParts parts{};
};

FiberParameters parameters_of(const Cell& cell) {
  FiberParameters parameters;
  parameters.eccentricity = cell.eccentricity;
  parameters.roughness = cell.alpha;
  parameters.tilt = cell.tilt_deg * degree;
  parameters.eta = cell.eta;
  cell.parts.give_to(parameters);
  return parameters;
}

/// By part: the energies at sigma_a 0, 0.15 and 0.9, then the means of cos x, sin x, cos 2x, tanh t and tanh^2 t; last
/// the energy of all parts.
constexpr std::size_t of_part = 8, all_means = fiber::rough_parts * of_part + 1;
using Sums = std::array<double, all_means>;
using Means = std::array<test::SampleMean, all_means>;

void add(Sums& sums, int order, float weight, float way, double azimuth, double height) {
  const auto w = static_cast<double>(weight), l = static_cast<double>(way), t = std::tanh(height);
  const std::array<double, of_part> values{
      1,    std::exp(-0.15 * l), std::exp(-0.9 * l), std::cos(azimuth), std::sin(azimuth), std::cos(2 * azimuth), t,
      t * t};
  for (std::size_t k = 0; k < of_part; ++k) sums[fiber::rough_part(order) * of_part + k] += w * values[k];
  sums.back() += w;
}

Sums one_by_one(const Cell& cell, const FiberDirection& wr, std::uint64_t key, std::uint32_t paths) {
  const RoughFiber rough(parameters_of(cell));
  const ScrambledSobol points(key);
  std::vector<fiber::SplitExit> exits;
  for (std::uint32_t i = 0; i < paths; ++i) {
    const ScrambledSobol::Point u = points.point(i);
    RandomStream random(key, i);
    rough.trace_split(rough.entry(wr, 2 * u[0] - 1), {{{u[1], u[2]}, {u[3], u[4]}, {u[5], u[6]}}}, random, exits,
                      rules);
  }
  Sums sums{};
  for (const fiber::SplitExit& exit : exits) {
    const glm::vec3& w = exit.direction;
    const double azimuth = std::atan2(static_cast<double>(w.z), static_cast<double>(w.y)) - static_cast<double>(wr.phi);
    const double across = std::hypot(static_cast<double>(w.y), static_cast<double>(w.z));
    add(sums, exit.order, exit.weight, exit.path, azimuth, std::asinh(static_cast<double>(w.x) / across));
  }
  return sums;
}

Sums in_lanes(const Cell& cell, const FiberDirection& wr, std::uint64_t key, std::uint32_t paths) {
  fiber::RoughPaths traced(parameters_of(cell), rules);
  traced.add_sobol(wr, key, 0, paths, 0);
  const fiber::RoughPathExits& exits = traced.trace();
  std::vector<float> azimuths, heights;
  exits.places(std::cos(wr.phi), std::sin(wr.phi), 12, azimuths, heights);
  Sums sums{};
  for (std::size_t i = 0; i < exits.size(); ++i) {
    add(sums, exits.order(i), exits.weight(i), exits.way(i), static_cast<double>(azimuths[i]),
        static_cast<double>(heights[i]));
  }
  return sums;
}

/// Every value with every other one in some cell, and the corners of all.
std::vector<Cell> cells() {
  constexpr std::array eccentricities{0.5f, 0.75f, 0.85f, 1.0f};
  constexpr std::array thetas{0.0f, 30.0f, -60.0f, 80.0f, 87.0f};
  constexpr std::array alphas{0.01f, 0.05f, 0.2f, 0.3f, 0.8f};
  constexpr std::array etas{1.55f, 1.05f, 2.0f};
  std::vector<Cell> all;
  for (std::size_t a = 0; a < alphas.size(); ++a) {
    for (std::size_t t = 0; t < thetas.size(); ++t) {
      for (std::size_t k = 0; k < 2; ++k) {
        const std::size_t turn = a + 2 * t + k;
        all.push_back({eccentricities[(turn + 2 * k) % 4], alphas[a], thetas[t], k == 0 ? 0.0f : 3.0f,
                       etas[turn % 4 < 2 ? 0 : (a + t + k) % 3]});
      }
    }
  }
  return all;
}

/// From cores that do nothing to dense ones.
std::vector<Cell> with_parts() {
  return {{0.85f, 0.2f, 30, 3, 1.55f, {0.5f, 0, 0, 0}},
          {0.75f, 0.1f, 0, 0, 1.55f, {0.5f, 2, 0, 0}},
          {1, 0.3f, -60, 3, 1.55f, {0.7f, 4, 0.4f, 0}},
          {0.6f, 0.05f, 80, 0, 1.55f, {0.3f, 20, -0.3f, 1}},
          {0.85f, 0.2f, 10, 3, 1.55f, {0.85f, 30, 0.8f, 0}},
          {0.5f, 0.8f, 87, 0, 2, {0.95f, 10, 0.5f, 3}},
          {0.9f, 0.02f, 45, 0, 1.3f, {0.8f, 0, 0, 0.7f}},
          {0.85f, 0.2f, 30, 3, 1.55f, {0, 0, 0, 0, 2, 0.3f}},
          {0.7f, 0.1f, -20, 0, 1.55f, {0.5f, 3, 0.6f, 0.4f, 0.7f, -0.2f}},
          {0.85f, 0.2f, 30, 3, 1.55f, {0, 0, 0, 0, 0, 0, 1}},
          {0.6f, 0.5f, -60, 3, 1.3f, {0.5f, 3, 0.6f, 0, 0.7f, -0.2f, 0.5f}},
          {0.75f, 0.02f, 80, 0, 1.55f, {0, 0, 0, 0, 0, 0, 0.3f}}};
}

// Of 62 fibers 33 means each, within 5 standard errors of both, of 64 batches each: a chance of 0.004 by the t law, or
// less, since means of a fiber go together. Weights sum to 1
// where no core absorbs.
void compare(const std::vector<Cell>& cells) {
  constexpr std::uint64_t batches = 64;
  const auto paths = static_cast<std::uint32_t>(test::scaled(1024));
  double largest = 0;
  for (const Cell& cell : cells) {
    const FiberDirection wr{cell.theta_deg * degree, 0.7f};
    Means scalar, lanes;
    for (std::uint64_t batch = 0; batch < batches; ++batch) {
      const Sums x = one_by_one(cell, wr, test::seed(5000) + batch, paths);
      const Sums y = in_lanes(cell, wr, test::seed(6000) + batch, paths);
      for (std::size_t k = 0; k < all_means; ++k) {
        scalar[k].add(x[k] / paths);
        lanes[k].add(y[k] / paths);
      }
    }
    double here = 0;
    for (std::size_t k = 0; k < all_means; ++k) {
      const double error = std::hypot(scalar[k].standard_error(), lanes[k].standard_error());
      const double off = std::abs(scalar[k].mean() - lanes[k].mean());
      if (error > 0) here = std::max(here, off / (error + 2e-7));
      EXPECT_LT(off, 5 * error + 1e-6) << "e " << cell.eccentricity << " alpha " << cell.alpha << " theta "
                                       << cell.theta_deg << " tilt " << cell.tilt_deg << " eta " << cell.eta << " part "
                                       << k / of_part << " mean " << k % of_part << ": " << scalar[k].mean()
                                       << ", in lanes " << lanes[k].mean() << " +- " << error;
    }
    largest = std::max(largest, here);
    if (!(cell.parts.absorption > 0)) {
      EXPECT_NEAR(lanes.back().mean(), 1, 5 * lanes.back().standard_error() + 2e-6);
    }
    std::printf("e %.2f alpha %.2f theta %3.0f tilt %.0f eta %.2f: all %.5f +- %.5f, largest deviation %.2f\n",
                static_cast<double>(cell.eccentricity), static_cast<double>(cell.alpha),
                static_cast<double>(cell.theta_deg), static_cast<double>(cell.tilt_deg), static_cast<double>(cell.eta),
                lanes.back().mean(), lanes.back().standard_error(), here);
  }
  std::printf("largest deviation %.2f\n", largest);
}

TEST(rough_paths_statistics, lanes_have_the_means_of_paths_one_by_one) { compare(cells()); }

TEST(rough_paths_statistics, so_they_have_through_medulla_cortex_and_water) { compare(with_parts()); }

}  // namespace
}  // namespace tress
