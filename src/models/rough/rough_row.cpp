#include "models/rough/rough_row.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <numbers>
#include <span>
#include <vector>

namespace tress::fiber {
namespace {

constexpr double radians_per_step = 2 * std::numbers::pi / 65536;
constexpr double most_steps = 65535;
constexpr double darkest_mass = 1e-30;

using adaptive::RibbonKnot;

/// A layer's knots: densities by channel, and how many steps it is from each to the next.
struct Layer {
  std::span<const RibbonKnot> knots;
  std::vector<std::array<double, 3>> density;
  std::vector<int> width;

  Layer(std::span<const RibbonKnot> all, const glm::vec3& sigma_a) : knots(all) {
    for (const RibbonKnot& knot : knots) {
      const adaptive::GammaDecay decay = adaptive::GammaDecay::from(knot.decays);
      std::array<double, 3>& colored = density.emplace_back();
      for (int c = 0; c < 3; ++c)
        colored[static_cast<std::size_t>(c)] = double{knot.density} * double{decay.at(sigma_a[c])};
    }
  }

  /// Mass from knot k to the next, of a channel.
  double mass(std::size_t k, std::size_t c) const {
    const std::size_t next = (k + 1) % density.size();
    return 0.5 * radians_per_step * width[k] * (density[k][c] + density[next][c]);
  }
  double mass(std::size_t c) const {
    double sum = 0;
    for (std::size_t k = 0; k < density.size(); ++k) sum += mass(k, c);
    return sum;
  }
};

std::uint16_t steps_of(double value, double unit) {
  return unit > 0 ? static_cast<std::uint16_t>(std::clamp(std::round(value / unit), 0.0, most_steps))
                  : std::uint16_t{0};
}

/// Writes the layer in steps, and takes what they tell for the layer's densities.
void pack(Layer& layer, PackedKnot* packed, LayerUnits& units) {
  for (std::size_t c = 0; c < 3; ++c) {
    double most = 0;
    for (const auto& density : layer.density) most = std::max(most, density[c]);
    const double unit = most / most_steps;
    for (std::size_t k = 0; k < layer.density.size(); ++k) {
      packed[k].steps[c] = steps_of(layer.density[k][c], unit);
      layer.density[k][c] = unit * packed[k].steps[c];
    }
    units.density[static_cast<int>(c)] = static_cast<float>(unit);
  }
  const auto pack_law = [&](int lane, float RibbonKnot::* member, double from, double most, double least_steps) {
    const double unit = (most - from) / most_steps;
    for (std::size_t k = 0; k < layer.knots.size(); ++k) {
      const double steps = std::max<double>(steps_of(double{layer.knots[k].*member} - from, unit), least_steps);
      packed[k].steps[static_cast<std::size_t>(4 + lane)] = static_cast<std::uint16_t>(steps);
    }
    units.law[lane] = static_cast<float>(unit);
    units.law_from[lane] = static_cast<float>(from);
  };
  const auto range_of = [&](float RibbonKnot::* member) {
    const auto [least, most] = std::ranges::minmax(layer.knots, {}, member);
    return std::array<double, 2>{double{least.*member}, double{most.*member}};
  };
  const std::array<double, 2> modes = range_of(&RibbonKnot::mode);
  pack_law(0, &RibbonKnot::mode, modes[0], modes[1], 0);
  pack_law(1, &RibbonKnot::scale_below, 0, range_of(&RibbonKnot::scale_below)[1], 1);
  pack_law(2, &RibbonKnot::scale_above, 0, range_of(&RibbonKnot::scale_above)[1], 1);
}

std::vector<int> widths_of(const std::vector<int>& azimuths) {
  std::vector<int> widths;
  for (std::size_t k = 0; k < azimuths.size(); ++k)
    widths.push_back(k + 1 < azimuths.size() ? azimuths[k + 1] - azimuths[k] : azimuths[0] + 65536 - azimuths[k]);
  return widths;
}

std::vector<int> main_azimuths(std::span<const RibbonKnot> knots) {
  std::vector<int> azimuths;
  for (const RibbonKnot& knot : knots) {
    const double steps = std::round((double{knot.azimuth} + std::numbers::pi) / radians_per_step);
    azimuths.push_back(static_cast<int>(std::clamp(steps, 0.0, most_steps)));
  }
  return azimuths;
}

void put_part(const adaptive::Ribbon& ribbon, const glm::vec3& sigma_a, RoughPart& part) {
  Layer main(ribbon.main(), sigma_a), broad(ribbon.broad(), sigma_a);
  const std::vector<int> azimuths = main_azimuths(ribbon.main());
  for (std::size_t k = 0; k < azimuths.size(); ++k) part.azimuth[k] = static_cast<std::int16_t>(azimuths[k] - 32768);
  main.width = widths_of(azimuths);
  broad.width.assign(RoughPart::broad_knots, 65536 / static_cast<int>(RoughPart::broad_knots));
  const std::array<double, 3> clear_before{main.mass(0) + broad.mass(0), main.mass(1) + broad.mass(1),
                                           main.mass(2) + broad.mass(2)};
  for (std::size_t c = 0; c < 3; ++c) {
    if (clear_before[c] > darkest_mass) continue;
    for (std::size_t k = 0; k < main.density.size(); ++k) main.density[k][c] = double{main.knots[k].density};
    for (std::size_t k = 0; k < broad.density.size(); ++k) broad.density[k][c] = double{broad.knots[k].density};
  }
  pack(main, part.main.data(), part.main_units);
  pack(broad, part.broad.data(), part.broad_units);
  for (std::size_t c = 0; c < 3; ++c) {
    const double all = main.mass(c) + broad.mass(c), scale = 1 / all;
    part.main_units.density[static_cast<int>(c)] *= static_cast<float>(scale);
    part.broad_units.density[static_cast<int>(c)] *= static_cast<float>(scale);
    double below = 0;
    for (std::size_t k = 0; k < main.density.size(); ++k) {
      if (k % RoughPart::group == 0) part.below[c][k / RoughPart::group] = static_cast<float>(below * scale);
      below += main.mass(k, c);
    }
    part.main_mass[static_cast<int>(c)] = static_cast<float>(below * scale);
  }
}

}  // namespace

const RoughRow* put_rough_row(const adaptive::RibbonRow& row, float objective, std::uint32_t paths,
                              const glm::vec3& sigma_a, const EnergyFactors& energies, void* memory) {
  auto* rough = new (memory) RoughRow;
  rough->objective = objective;
  rough->paths = paths;
  const auto in_lanes = [](const glm::vec3& color) { return Float4{color.x, color.y, color.z, 1}; };
  std::ranges::transform(energies.part, rough->energy.begin(), in_lanes);
  rough->whole_energy = in_lanes(energies.whole);
  for (std::uint32_t p = 0; p < RoughRow::parts; ++p) {
    const adaptive::Ribbon ribbon = p < row.parts() ? row.ribbon(p) : adaptive::Ribbon();
    rough->is_normal[static_cast<int>(p)] = ribbon.main_law() == adaptive::HeightLaw::normal ? -1 : 0;
    put_part(ribbon, sigma_a, rough->part[p]);
  }
  return rough;
}

}  // namespace tress::fiber
