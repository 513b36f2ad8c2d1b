#include "fiber/traced_energies.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "base/pi.h"
#include "fiber/cross_section.h"
#include "fiber/rough_fiber.h"
#include "fiber/rough_paths.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::fiber {
namespace {

std::uint64_t seed_of(const EnergyKey& key) {
  std::uint64_t seed = 0;
  for (const float x : {key.eta, key.eccentricity, key.roughness, key.tilt}) {
    seed = mix_bits(seed + std::bit_cast<std::uint32_t>(x));
  }
  if (key.parts == TracedParts{}) return seed;
  constexpr std::size_t of_medulla = 4;
  const auto values = key.parts.values();
  for (std::size_t i = 0; i < values.size(); ++i)
    if (i < of_medulla || values[i] != 0) seed = mix_bits(seed + std::bit_cast<std::uint32_t>(values[i]));
  return seed;
}

/// The factor on order k of a series with that many nodes; it damps noise and Gibbs oscillations.
double kept(std::size_t k, std::size_t nodes) {
  const double x = static_cast<double>(k) / static_cast<double>(nodes);
  return std::exp(-6 * x * x * x * x);
}

/// The matrix from values at the nodes angle_j = (j + 1/2) pi/n to values at other angles, through sum_k c_k cos(k
/// angle).
std::vector<double> cosine_series(std::size_t nodes, const std::vector<double>& angles) {
  std::vector<double> matrix(nodes * angles.size());
  for (std::size_t i = 0; i < angles.size(); ++i) {
    for (std::size_t j = 0; j < nodes; ++j) {
      const double at_node = (static_cast<double>(j) + 0.5) * pi / static_cast<double>(nodes);
      double sum = 1;
      for (std::size_t k = 1; k < nodes; ++k) {
        const auto order = static_cast<double>(k);
        sum += 2 * kept(k, nodes) * std::cos(order * angles[i]) * std::cos(order * at_node);
      }
      matrix[i * nodes + j] = sum / static_cast<double>(nodes);
    }
  }
  return matrix;
}

}  // namespace

EnergyKey energy_key(const FiberParameters& fiber) {
  return {fiber.eta,
          fiber.eccentricity,
          fiber.roughness,
          fiber.tilt,
          fiber.split_glint ? azimuthal_sigmas(fiber)[1] : 0,
          std::max(1, static_cast<int>(std::lround(static_cast<float>(EnergyKey{}.paths) * fiber.energy_path_share))),
          TracedParts::of(fiber)};
}

double length_decay(Lobe lobe) {
  constexpr std::array<double, lobe_count> decay{1, 0.3, 0.2, 0.15, 0.05, 0.2};
  return decay[static_cast<std::size_t>(lobe)];
}

TracedEnergies::TracedEnergies(const EnergyKey& key)
    : azimuths_(key.eccentricity < 1 ? most_azimuths : 1),
      paths_(key.eccentricity < 1 ? key.paths : 4 * key.paths),
      nodes_(azimuths_ * inclinations) {
  const bool even = !(key.tilt > 0);  // theta and -theta give the same
  const std::size_t own = (even ? (inclinations + 1) / 2 : inclinations) * azimuths_;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, own, 1), [&](const auto& range) {
    for (std::size_t node = range.begin(); node != range.end(); ++node) nodes_[node] = traced(key, node);
  });
  for (std::size_t node = own; node < nodes_.size(); ++node) {
    nodes_[node] = nodes_[(inclinations - 1 - node / azimuths_) * azimuths_ + node % azimuths_];
  }
}

TracedEnergies::Fields TracedEnergies::traced(const EnergyKey& key, std::size_t node) const {
  FiberParameters parameters;
  parameters.eta = key.eta;
  parameters.eccentricity = key.eccentricity;
  parameters.roughness = key.roughness;
  parameters.tilt = key.tilt;
  key.parts.give_to(parameters);
  const RoughFiber fiber(parameters);
  const double phi = (static_cast<double>(node % azimuths_) + 0.5) * pi / 2 / static_cast<double>(azimuths_);
  const double theta =
      pi / 2 * std::cos((static_cast<double>(node / azimuths_) + 0.5) * pi / static_cast<double>(inclinations));
  const FiberDirection wr{static_cast<float>(theta), static_cast<float>(phi)};
  const CrossSection section(static_cast<double>(key.eta), static_cast<double>(key.eccentricity), phi, theta);
  RandomStream random(seed_of(key), node);
  // Offsets are midpoints and facets an additive recurrence (of the root of x^7 = x + 1), both with a random shift.
  constexpr double root = 1.1127756842787055;
  std::array<double, 7> place, step;
  double power = 1;
  for (std::size_t d = 0; d < place.size(); ++d) {
    place[d] = static_cast<double>(random.next());
    step[d] = power /= root;
  }
  const auto offset = [&](std::uint32_t path) { return 2 * (path + place[6]) / paths_ - 1; };
  RoughPaths traced(parameters);
  for (std::uint32_t path = 0; path < static_cast<std::uint32_t>(paths_); ++path) {
    RoughFiber::FacetNumbers u;
    for (std::size_t d = 0; d < 6; ++d) {
      place[d] += step[d];
      place[d] -= std::floor(place[d]);
      u[d / 2][d % 2] = std::min(static_cast<float>(place[d]), 0.99999994f);
    }
    const auto seed = static_cast<std::uint32_t>(random.next_bits() >> 32);
    traced.add(fiber.entry(wr, static_cast<float>(offset(path))), u, seed, path, 0);
  }
  const RoughPathExits& exits = traced.trace();
  Fields sum{};
  for (std::size_t i = 0; i < exits.size(); ++i) {
    const double weight = static_cast<double>(exits.weight(i)) / paths_;
    if (exits.order(i) == 0) {
      sum[0] += weight;
      continue;
    }
    const auto add = [&](Lobe lobe, double w) {
      const double y = std::exp(-length_decay(lobe) * static_cast<double>(exits.way(i)));
      for (std::size_t k = 0; k < 6; ++k, w *= y) sum[1 + static_cast<std::size_t>(lobe) * 6 + k] += w;
    };
    const auto lobe = static_cast<Lobe>(std::min(exits.order(i), static_cast<int>(Lobe::residual)));
    const bool splits = lobe == Lobe::trt && key.glint_sigma > 0;
    const double glint = splits ? section.glint_share(offset(exits.path(i)), static_cast<double>(key.glint_sigma)) : 0;
    add(lobe, weight * (1 - glint));
    if (glint > 0) add(Lobe::glint, weight * glint);
  }
  return sum;
}

std::vector<LobeMoments> TracedEnergies::at(const std::vector<double>& phi, const std::vector<double>& theta) const {
  std::vector<double> angles;
  for (const double x : phi) angles.push_back(2 * x);
  const std::vector<double> along = cosine_series(azimuths_, angles);
  angles.clear();
  for (const double x : theta) angles.push_back(std::acos(std::clamp(2 * x / pi, -1.0, 1.0)));
  const std::vector<double> across = cosine_series(inclinations, angles);
  std::vector<Fields> rows(inclinations * phi.size());
  for (std::size_t j = 0; j < inclinations; ++j) {
    for (std::size_t i = 0; i < phi.size(); ++i) {
      for (std::size_t k = 0; k < azimuths_; ++k) {
        const double share = along[i * azimuths_ + k];
        for (std::size_t f = 0; f < fields; ++f) rows[j * phi.size() + i][f] += share * nodes_[j * azimuths_ + k][f];
      }
    }
  }
  std::vector<LobeMoments> out(theta.size() * phi.size());
  for (std::size_t t = 0; t < theta.size(); ++t) {
    for (std::size_t i = 0; i < phi.size(); ++i) {
      Fields sum{};
      for (std::size_t j = 0; j < inclinations; ++j) {
        const double share = across[t * inclinations + j];
        for (std::size_t f = 0; f < fields; ++f) sum[f] += share * rows[j * phi.size() + i][f];
      }
      LobeMoments& moments = out[t * phi.size() + i];
      moments.reflected = sum[0];
      for (std::size_t l = 0; l < lobe_count; ++l) std::copy_n(sum.begin() + 1 + 6 * l, 6, moments.later[l].begin());
    }
  }
  return out;
}

}  // namespace tress::inline v0_2::fiber
