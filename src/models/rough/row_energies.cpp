#include "models/rough/row_energies.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>

namespace tress::inline v0_2::fiber {
namespace {

using adaptive::Ribbon;
using adaptive::RibbonKnot;

constexpr std::size_t rates = 3;  // the rates of the comparison: 0 and Ribbon::decay_rates
/// Limits of a ratio: energies below the share `darkest` of all light are not compared, and ratios are clamped to
/// largest_ratio. At grazing light and with a tilt that lets in little light, the table, which interpolates by cosines,
/// may be off by more than a factor of 2.
constexpr double darkest = 1e-5, largest_ratio = 16;

/// Number of paths at which a row's energies are as precise as the table's, and the power of the number of paths by
/// which their variance falls (the points are Sobol's). Over 32 nodes the row's whole differs from 2^18 paths by 0.020
/// (512 paths), 0.007 (2,048) and 0.002 (8,192) at sigma_a 0.1; the table's differs by 0.009.
constexpr double paths_of_table = 1400, power_of_paths = 1.5;
/// For a part with the share m of all light, the variance of the logarithm in the row is at most about this (1/m - 1) /
/// paths^1.5. If row and table differ by more than three standard deviations, the table is wrong.
constexpr double variance_of_part = 6, deviations = 3;

/// The weight of `logarithm`, ln of the row's energy over the table's. known: the row's energy as a share of all light.
double trust(double logarithm, double known, std::uint64_t paths) {
  const double n = std::pow(static_cast<double>(paths), power_of_paths);
  const double variance = variance_of_part * (1 / std::min(known, 1.0) - 1) / n;
  const double square = logarithm * logarithm, by_paths = n / (n + std::pow(paths_of_table, power_of_paths));
  return square > 0 ? std::max(by_paths, 1 - deviations * deviations * variance / square) : by_paths;
}

using AtRates = std::array<double, rates>;

/// Adds the light that a layer keeps at each rate, by trapezoids between knots.
void add_kept(std::span<const RibbonKnot> knots, AtRates& kept) {
  constexpr float two_pi = 2 * std::numbers::pi_v<float>;
  float before = knots.front().azimuth + two_pi - knots.back().azimuth;
  for (std::size_t k = 0; k < knots.size(); ++k) {
    const RibbonKnot& knot = knots[k];
    const float after =
        k + 1 < knots.size() ? knots[k + 1].azimuth - knot.azimuth : knots.front().azimuth + two_pi - knot.azimuth;
    const float light = 0.5f * (before + after) * knot.density;
    kept[0] += static_cast<double>(light);
    for (std::size_t i = 0; i < knot.decays.size(); ++i) kept[i + 1] += static_cast<double>(light * knot.decays[i]);
    before = after;
  }
}

/// ln of the ratio at sigma, interpolated between those at the rates.
double interpolated(const AtRates& logarithms, double sigma) {
  constexpr auto first = static_cast<double>(Ribbon::decay_rates[0]),
                 second = static_cast<double>(Ribbon::decay_rates[1]);
  if (sigma <= first) return logarithms[0] + (logarithms[1] - logarithms[0]) * sigma / first;
  const double share = std::min(std::log(sigma / first) / std::log(second / first), 1.0);
  return logarithms[1] + (logarithms[2] - logarithms[1]) * share;
}

/// The energies of the parts of a row, from the table's lobes at one direction and absorption.
std::array<double, rough_parts> parts_of(const std::array<double, lobe_count>& lobes) {
  return {lobes[0], lobes[1], lobes[2] + lobes[static_cast<std::size_t>(Lobe::glint)], lobes[3] + lobes[4]};
}

}  // namespace

/// The row and the table, by rate and part.
struct RowEnergies::Compared {
  std::array<std::array<double, rough_parts>, rates> known{};  ///< by the row, scaled to the table's sum in clear hair
  std::array<AtRates, rough_parts> logarithms{};               ///< of the row's energy over the table's, as trusted
  std::array<AtRates, rough_parts> whole_logarithms{};         ///< the same, as they are
  double scale = 0;                                            ///< of the row's masses; 0 if there is no light
};

RowEnergies::Compared RowEnergies::compare(const adaptive::DecodedRow& row, std::uint64_t paths, float theta_r,
                                           float phi_r) const {
  const auto table_at = [&](double sigma) {
    return parts_of(table_->without_gain(phi_r, theta_r, static_cast<float>(sigma)));
  };
  const std::array<std::array<double, rough_parts>, rates> table{table_at(0),
                                                                 table_at(static_cast<double>(Ribbon::decay_rates[0])),
                                                                 table_at(static_cast<double>(Ribbon::decay_rates[1]))};
  double whole = 0, mass = 0;
  for (std::uint32_t p = 0; p < rough_parts; ++p) {
    whole += table[0][p];
    mass += p < row.parts ? static_cast<double>(row.mass[p]) : 0.0;
  }
  Compared compared;
  if (!(mass > 0) || !(whole > 0)) return compared;
  compared.scale = whole / mass;
  for (std::uint32_t p = 0; p < std::min(row.parts, rough_parts); ++p) {
    AtRates kept{};
    add_kept(row.ribbon[p].main(), kept);
    add_kept(row.ribbon[p].broad(), kept);
    for (std::size_t i = 0; i < rates; ++i) {
      const double known = compared.known[i][p] = static_cast<double>(row.mass[p]) * compared.scale * kept[i] / kept[0];
      if (known > darkest && table[i][p] > darkest) {
        const double ratio = std::clamp(known / table[i][p], 1 / largest_ratio, largest_ratio);
        const double logarithm = compared.whole_logarithms[p][i] = std::log(ratio);
        compared.logarithms[p][i] = trust(logarithm, known, paths) * logarithm;
      }
    }
  }
  return compared;
}

std::array<std::array<float, 3>, rough_parts> RowEnergies::corrections(const adaptive::DecodedRow& row,
                                                                       std::uint64_t paths, float theta_r,
                                                                       float phi_r) const {
  const Compared compared = compare(row, paths, theta_r, phi_r);
  std::array<std::array<float, 3>, rough_parts> logarithms{};
  if (!(compared.scale > 0)) return logarithms;
  double before = 0, after = 0;
  for (std::size_t p = 0; p < rough_parts; ++p) {
    before += compared.known[0][p];
    after += compared.known[0][p] * std::exp(compared.logarithms[p][0] - compared.whole_logarithms[p][0]);
  }
  for (std::size_t p = 0; p < rough_parts; ++p) {
    for (std::size_t i = 0; i < rates; ++i) {
      logarithms[p][i] = static_cast<float>(compared.logarithms[p][i] - compared.whole_logarithms[p][i] +
                                            std::log(compared.scale) + (i == 0 ? std::log(before / after) : 0.0));
    }
  }
  return logarithms;
}

EnergyFactors RowEnergies::at(const adaptive::DecodedRow& row, std::uint64_t paths, float theta_r, float phi_r) const {
  const Compared compared = compare(row, paths, theta_r, phi_r);
  EnergyFactors factors;
  if (!(compared.scale > 0)) return factors;
  for (int c = 0; c < 3; ++c) {
    const auto sigma = static_cast<double>(sigma_a_[c]);
    const std::array<double, rough_parts> energy =
        parts_of(table_->without_gain(phi_r, theta_r, static_cast<float>(sigma)));
    double before = 0, after = 0;
    for (std::size_t p = 0; p < rough_parts; ++p) {
      const double factor = std::exp(interpolated(compared.logarithms[p], sigma));
      factors.part[p][c] = static_cast<float>(factor);
      before += energy[p];
      after += factor * energy[p];
    }
    factors.whole[c] = sigma > 0 && before > 0 ? static_cast<float>(after / before) : 1.0f;
  }
  return factors;
}

}  // namespace tress::inline v0_2::fiber
