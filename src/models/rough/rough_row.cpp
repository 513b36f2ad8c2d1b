#include "models/rough/rough_row.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <new>
#include <numbers>
#include <span>

#include "base/exp_of_negative.h"
#include "base/instruction_sets.h"
#include "base/logarithm.h"

// Loops over knots, without calls or branches, are compiled into lanes of every instruction set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "models/rough/rough_row.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tress::inline v0_2::fiber {
namespace HWY_NAMESPACE {

constexpr float radians_per_step = 2 * std::numbers::pi_v<float> / 65536;
constexpr float most_steps = 65535;
constexpr float darkest_mass = 1e-30f;

using adaptive::RibbonKnot;

// The densities of knots by channel, each times what the color leaves of it.
template <std::size_t count>
HWY_INLINE void Color(const ColoredDecays& decays, std::span<const RibbonKnot> knots,
                      std::array<std::array<float, count>, 3>& densities) {
  constexpr float least_decay = 1e-37f, least_logarithm = 1e-7f;
  constexpr float most_ratio = ColoredDecays::most_ratio;
  constexpr float per_ratio = static_cast<float>(ColoredDecays::steps) / (most_ratio - 1);
  std::array<float, count> first, place;
  for (std::size_t k = 0; k < count; ++k) {
    first[k] = std::clamp(knots[k].decays[0], least_decay, 1.0f);
    place[k] = std::clamp(knots[k].decays[1], least_decay, 1.0f);
  }
  for (std::size_t k = 0; k < count; ++k) {
    first[k] = std::max(-natural_log(first[k]), 0.0f);
    const float ratio = -natural_log(place[k]) / std::max(first[k], least_logarithm);
    place[k] = (std::clamp(ratio, 1.0f, most_ratio) - 1) * per_ratio;
  }
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = std::min(static_cast<std::size_t>(static_cast<int>(place[k])), ColoredDecays::steps - 1);
    const float share = place[k] - static_cast<float>(i);
    for (std::size_t c = 0; c < 3; ++c) {
      const auto& table = decays.by_ratio()[c];
      densities[c][k] = -first[k] * (table[i] + share * (table[i + 1] - table[i]));
    }
  }
  for (std::array<float, count>& density : densities) {
    for (std::size_t k = 0; k < count; ++k) density[k] = exp_of_negative(density[k]);
    for (std::size_t k = 0; k < count; ++k) density[k] *= knots[k].density;
  }
}

/// A layer's knots: densities by channel, and how many steps it is from each to the next.
template <std::size_t count>
struct Layer {
  std::span<const RibbonKnot> knots;
  std::array<std::array<float, count>, 3> density;
  std::array<int, count> width;

  Layer(std::span<const RibbonKnot> all, const ColoredDecays& decays) : knots(all) { Color(decays, knots, density); }
  void make_clear(std::size_t c) {
    for (std::size_t k = 0; k < count; ++k) density[c][k] = knots[k].density;
  }

  /// Mass from knot k to the next, of a channel.
  float mass(std::size_t k, std::size_t c) const {
    const float next = density[c][k + 1 < count ? k + 1 : 0];
    return 0.5f * radians_per_step * static_cast<float>(width[k]) * (density[c][k] + next);
  }
  float mass(std::size_t c) const {
    float sum = 0;
    for (std::size_t k = 0; k < count; ++k) sum += mass(k, c);
    return sum;
  }
};

// The value of one step if the largest value is `most`; 0 if that is too small for a normal number.
HWY_INLINE float UnitOf(float most) {
  constexpr float least = 1e-33f;
  return most > least ? most / most_steps : 0;
}

HWY_INLINE std::uint16_t StepsOf(float value, float per_unit) {
  return static_cast<std::uint16_t>(static_cast<int>(std::clamp(value * per_unit + 0.5f, 0.0f, most_steps)));
}

/// Writes the layer in steps, and rounds the layer's densities to them.
template <std::size_t count>
void Pack(Layer<count>& layer, std::array<PackedKnot, count>& packed, LayerUnits& units) {
  for (std::size_t c = 0; c < 3; ++c) {
    std::array<float, count>& density = layer.density[c];
    const float most = std::ranges::max(density), unit = UnitOf(most), per_unit = unit > 0 ? 1 / unit : 0;
    for (std::size_t k = 0; k < count; ++k) {
      packed[k].steps[c] = StepsOf(density[k], per_unit);
      density[k] = unit * packed[k].steps[c];
    }
    units.density[static_cast<int>(c)] = unit;
  }
  const auto pack_law = [&](int lane, float RibbonKnot::* member, float from, float most, std::uint16_t least_steps) {
    const float unit = UnitOf(most - from), per_unit = unit > 0 ? 1 / unit : 0;
    for (std::size_t k = 0; k < count; ++k) {
      packed[k].steps[static_cast<std::size_t>(4 + lane)] =
          std::max(StepsOf(layer.knots[k].*member - from, per_unit), least_steps);
    }
    units.law[lane] = unit;
    units.law_from[lane] = from;
  };
  const auto range_of = [&](float RibbonKnot::* member) {
    const auto [least, most] = std::ranges::minmax(layer.knots, {}, member);
    return std::array<float, 2>{least.*member, most.*member};
  };
  const std::array<float, 2> modes = range_of(&RibbonKnot::mode);
  pack_law(0, &RibbonKnot::mode, modes[0], modes[1], 0);
  pack_law(1, &RibbonKnot::scale_below, 0, range_of(&RibbonKnot::scale_below)[1], 1);
  pack_law(2, &RibbonKnot::scale_above, 0, range_of(&RibbonKnot::scale_above)[1], 1);
}

void PutPart(const adaptive::Ribbon& ribbon, const ColoredDecays& decays, RoughPart& part) {
  Layer<RoughPart::main_knots> main(ribbon.main(), decays);
  Layer<RoughPart::broad_knots> broad(ribbon.broad(), decays);
  std::array<int, RoughPart::main_knots> azimuths;
  for (std::size_t k = 0; k < azimuths.size(); ++k) {
    azimuths[k] = StepsOf(ribbon.main()[k].azimuth + std::numbers::pi_v<float>, 1 / radians_per_step);
    part.azimuth[k] = static_cast<std::int16_t>(azimuths[k] - 32768);
  }
  for (std::size_t k = 0; k + 1 < azimuths.size(); ++k) main.width[k] = azimuths[k + 1] - azimuths[k];
  main.width.back() = azimuths.front() + 65536 - azimuths.back();
  broad.width.fill(65536 / static_cast<int>(RoughPart::broad_knots));
  for (std::size_t c = 0; c < 3; ++c) {
    if (main.mass(c) + broad.mass(c) > darkest_mass) continue;
    main.make_clear(c);
    broad.make_clear(c);
  }
  Pack(main, part.main, part.main_units);
  Pack(broad, part.broad, part.broad_units);
  for (std::size_t c = 0; c < 3; ++c) {
    const float scale = 1 / (main.mass(c) + broad.mass(c));
    part.main_units.density[static_cast<int>(c)] *= scale;
    part.broad_units.density[static_cast<int>(c)] *= scale;
    float below = 0;
    for (std::size_t k = 0; k < RoughPart::main_knots; ++k) {
      if (k % RoughPart::group == 0) part.below[c][k / RoughPart::group] = below * scale;
      below += main.mass(k, c);
    }
    part.main_mass[static_cast<int>(c)] = below * scale;
  }
}

const RoughRow* PutRoughRow(const adaptive::DecodedRow& row, float objective, std::uint32_t paths,
                            const ColoredDecays& decays, const EnergyFactors& energies, void* memory) {
  auto* rough = new (memory) RoughRow;
  rough->objective = objective;
  rough->paths = paths;
  const auto in_lanes = [](const glm::vec3& color) { return Float4{color.x, color.y, color.z, 1}; };
  std::ranges::transform(energies.part, rough->energy.begin(), in_lanes);
  rough->whole_energy = in_lanes(energies.whole);
  for (std::uint32_t p = 0; p < RoughRow::parts; ++p) {
    const adaptive::Ribbon& ribbon = row.ribbon[p];
    rough->is_normal[static_cast<int>(p)] = ribbon.main_law() == adaptive::HeightLaw::normal ? -1 : 0;
    PutPart(ribbon, decays, rough->part[p]);
  }
  return rough;
}

}  // namespace HWY_NAMESPACE
}  // namespace tress::inline v0_2::fiber
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tress::inline v0_2::fiber {

HWY_EXPORT(PutRoughRow);

const RoughRow* put_rough_row(const adaptive::DecodedRow& row, float objective, std::uint32_t paths,
                              const ColoredDecays& decays, const EnergyFactors& energies, void* memory) {
  return HWY_DYNAMIC_DISPATCH(PutRoughRow)(row, objective, paths, decays, energies, memory);
}

}  // namespace tress::inline v0_2::fiber
#endif
