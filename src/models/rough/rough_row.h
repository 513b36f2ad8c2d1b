// A row of the rough fiber for one color: the data that a vertex reads, in as few cache lines as possible.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>

#include "base/float4.h"
#include "models/rough/colored_decays.h"
#include "models/rough/row_energies.h"
#include "tress/adaptive/ribbon.h"

namespace tress::inline v0_2::fiber {

/// One knot of a layer, in steps of its LayerUnits. The lanes are: densities of R, G, B; unused; mode of the height;
/// its scale below and above; unused.
struct alignas(16) PackedKnot {
  std::array<std::uint16_t, 8> steps{};
};

/// value = steps times unit; the height also has `from` added. Lanes as in PackedKnot.
struct LayerUnits {
  Float4 density = splat(0);  ///< 1/rad and unit of the part's height
  Float4 law = splat(0), law_from = splat(0);
};

/// A part of a row under one absorption, of mass 1 in each channel. Azimuths are in 65536ths of a turn, from -32768 on.
struct alignas(64) RoughPart {
  static constexpr std::size_t main_knots = adaptive::Ribbon::main_knots, broad_knots = adaptive::Ribbon::broad_knots;
  static constexpr std::size_t group = 4, groups = main_knots / group;

  using Azimuths = std::array<std::int16_t, main_knots>;
  alignas(64) Azimuths azimuth{};  ///< ascending
  std::array<PackedKnot, main_knots> main{};
  std::array<PackedKnot, broad_knots> broad{};
  LayerUnits main_units, broad_units;
  /// Mass of the main layer, by channel, from knot 0 to the first knot of each group.
  std::array<std::array<float, groups>, 3> below{};
  glm::vec3 main_mass{0.0f};
};

/// Parts are numbered as by rough_part(). Plain data: it owns nothing and is never destroyed.
struct alignas(64) RoughRow {
  static constexpr std::size_t parts = 4;
  Int4 is_normal;  ///< by part: all bits set if the law of its main layer is HeightLaw::normal
  float objective = 0;
  std::uint32_t paths = 0;           ///< number of paths from which it was learned
  std::array<Float4, parts> energy;  ///< from EnergyFactors; lane 3 is 1
  Float4 whole_energy = splat(1);    ///< from EnergyFactors; lane 3 is 1
  std::array<RoughPart, parts> part;
};

/// Colors a row: multiplies each knot's density by what the color leaves there, by channel, then scales each channel to
/// mass 1. A channel of a part without any light left gets the clear shape. memory: aligned to 64, of sizeof(RoughRow).
const RoughRow* put_rough_row(const adaptive::DecodedRow& row, float objective, std::uint32_t paths,
                              const ColoredDecays& decays, const EnergyFactors& energies, void* memory);

}  // namespace tress::inline v0_2::fiber
