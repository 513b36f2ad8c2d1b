// The oracle of traced rough fibers (fiber3d.csv), and a comparison of our tracer with it.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "fiber/reference_data.h"
#include "fiber/rough_fiber.h"
#include "support/chi_square.h"
#include "tress/base/random.h"
#include "tress/fiber/parameters.h"

namespace tress::test {

/// 36 bins of theta_i from -90 degrees, in each 36 of phi_i from -180: fractions of unit flux.
constexpr int flux_bins_a_side = 36;
using FluxBins = std::array<double, flux_bins_a_side * flux_bins_a_side>;
constexpr std::array<const char*, 4> flux_lobes{"R", "TT", "TRT", "TRRT+"};

inline std::size_t flux_bin(const fiber::FiberDirection& wi) {
  constexpr float pi = std::numbers::pi_v<float>;
  const auto index = [](float turn) {
    return static_cast<std::size_t>(std::clamp(static_cast<int>(turn * flux_bins_a_side), 0, flux_bins_a_side - 1));
  };
  return index(wi.theta / pi + 0.5f) * flux_bins_a_side + index(0.5f * (wi.phi / pi + 1));
}

/// One configuration of the reference: an untilted fiber of one absorption.
struct Fiber3dReference {
  fiber::FiberParameters parameters;
  fiber::FiberDirection wr;
  std::array<FluxBins, 4> flux{}, standard_error{};  ///< by flux_lobes
};

/// By their number in fiber3d.csv, from its rows; bins without a row are 0.
inline std::map<int, Fiber3dReference> fiber3d_reference(const ReferenceRows& rows) {
  constexpr double degree = std::numbers::pi / 180;
  std::map<int, Fiber3dReference> all;
  for (const std::vector<std::string>& field : rows) {
    const auto number = [&](std::size_t i) { return std::stod(field[i]); };
    Fiber3dReference& reference = all[std::stoi(field[0])];
    fiber::FiberParameters& parameters = reference.parameters;
    parameters.eta = static_cast<float>(number(1));
    parameters.eccentricity = static_cast<float>(number(2));
    parameters.roughness = static_cast<float>(number(3));
    parameters.tilt = 0;
    parameters.sigma_a = glm::vec3(static_cast<float>(number(6)));
    reference.wr = {static_cast<float>(number(4) * degree), static_cast<float>(number(5) * degree)};
    const auto lobe = static_cast<std::size_t>(std::ranges::find(flux_lobes, field[7]) - flux_lobes.begin());
    FluxBins& bins = (field[8] == "E" ? reference.flux : reference.standard_error)[lobe];
    for (std::size_t j = 0; j < flux_bins_a_side; ++j) {
      bins[static_cast<std::size_t>(std::stoi(field[9])) * flux_bins_a_side + j] = number(10 + j);
    }
  }
  return all;
}

/// Flux that leaves, by lobe and bin, with the sums of its squares.
struct TracedFlux {
  std::array<FluxBins, 4> flux{}, squares{};
};

/// `paths` paths, stratified in h.
inline TracedFlux trace_flux(const fiber::FiberParameters& parameters, const fiber::FiberDirection& wr, int paths,
                             std::uint64_t seed) {
  const fiber::RoughFiber rough(parameters, fiber::Masked::is_lost);
  RandomStream random(seed);
  TracedFlux traced;
  for (int i = 0; i < paths; ++i) {
    const double h = 2 * (i + static_cast<double>(random.next())) / paths - 1;
    const std::array<float, 4> u{random.next(), random.next(), random.next(), random.next()};
    const fiber::RoughExit exit = rough.trace(rough.entry(wr, static_cast<float>(h)), u, random);
    const auto weight = static_cast<double>(exit.throughput.g);
    if (!(weight > 0)) continue;
    const auto lobe = static_cast<std::size_t>(std::min(exit.order, 3));
    const std::size_t bin = flux_bin(exit.angles());
    traced.flux[lobe][bin] += weight / paths;
    traced.squares[lobe][bin] += weight * weight / paths;
  }
  return traced;
}

/// One lobe of one configuration against the reference. Bins that expect fewer than 25 paths are pooled.
struct FluxComparison {
  double energy = 0, expected_energy = 0;
  double energy_error = 0;  ///< standard error of the difference
  ChiSquare chi_square;
  double largest_deviation = 0;  ///< of a bin: (|ours - theirs| - 1e-6) in standard errors of both together
};

inline FluxComparison compare_flux(const Fiber3dReference& reference, const TracedFlux& traced, std::size_t lobe,
                                   int paths) {
  FluxComparison result;
  double energy_variance = 0, pooled = 0, pooled_expected = 0, pooled_variance = 0;
  int cells = 0;
  const auto add = [&](double difference, double variance) {
    if (!(variance > 0)) return;
    const double z2 = difference * difference / variance;
    result.chi_square.statistic += z2;
    ++cells;
    result.largest_deviation = std::max(result.largest_deviation, (std::abs(difference) - 1e-6) / std::sqrt(variance));
  };
  for (std::size_t bin = 0; bin < traced.flux[lobe].size(); ++bin) {
    const double ours = traced.flux[lobe][bin], theirs = reference.flux[lobe][bin];
    const double their_error = reference.standard_error[lobe][bin];
    // Theirs has less noise: the variance of ours is that of the flux that they expect, of paths of our mean weight.
    const double mean_weight = ours > 0 ? traced.squares[lobe][bin] / ours : 1;
    const double variance = theirs * (mean_weight - theirs) / paths + their_error * their_error;
    result.energy += ours;
    result.expected_energy += theirs;
    energy_variance += their_error * their_error + theirs * mean_weight / paths;
    if (theirs * paths >= 25) {
      add(ours - theirs, variance);
    } else {
      pooled += ours;
      pooled_expected += theirs;
      pooled_variance += variance;
    }
  }
  if (pooled_expected * paths >= 25) add(pooled - pooled_expected, pooled_variance);
  result.energy_error = std::sqrt(energy_variance);
  result.chi_square.degrees_of_freedom = cells;  // energies are not made to agree
  result.chi_square.p_value = upper_gamma(0.5 * cells, 0.5 * result.chi_square.statistic);
  return result;
}

}  // namespace tress::test
