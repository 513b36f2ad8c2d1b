// A row of the rough fiber as one color sees it: what a vertex reads of it, in as few lines of the cache as it can.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>

#include "base/float4.h"
#include "models/rough/colored_decays.h"
#include "models/rough/row_energies.h"
#include "tress/adaptive/ribbon.h"

namespace tress::fiber {

/// One knot of a layer, in steps of its LayerUnits: densities of R, G, B, nothing, the mode of the height, its scale
/// below and above, nothing.
struct alignas(16) PackedKnot {
  std::array<std::uint16_t, 8> steps{};
};

/// value = steps unit, of the height also + from: lanes as in PackedKnot.
struct LayerUnits {
  Float4 density = splat(0);  ///< 1/rad and unit of the part
  Float4 law = splat(0), law_from = splat(0);
};

/// A part of a row under one absorption, of mass 1 in each channel. Azimuths in 65536ths of a turn from -pi on, less
/// 32768.
struct alignas(64) RoughPart {
  static constexpr std::size_t main_knots = adaptive::Ribbon::main_knots, broad_knots = adaptive::Ribbon::broad_knots;
  static constexpr std::size_t group = 4, groups = main_knots / group;

  std::array<std::int16_t, main_knots> azimuth{};  ///< ascending
  std::array<PackedKnot, main_knots> main{};
  std::array<PackedKnot, broad_knots> broad{};
  LayerUnits main_units, broad_units;
  /// Mass of the main layer, by channel, from knot 0 to the first of each group.
  std::array<std::array<float, groups>, 3> below{};
  glm::vec3 main_mass{0.0f};
};

/// Parts as rough_part() numbers them. Plain data: owns nothing, never destroyed.
struct alignas(64) RoughRow {
  static constexpr std::size_t parts = 4;
  Int4 is_normal;  ///< by part: all bits where the law of its main layer is HeightLaw::normal
  float objective = 0;
  std::uint32_t paths = 0;           ///< that taught it
  std::array<Float4, parts> energy;  ///< EnergyFactors, lane 3: 1
  Float4 whole_energy = splat(1);    ///< the same
  std::array<RoughPart, parts> part;
};

/// Colors a row: each knot's density times what the color leaves there, by channel, then mass 1. Where no light is left
/// in a channel of a part, it has the clear shape. memory: aligned to 64, of sizeof(RoughRow).
const RoughRow* put_rough_row(const adaptive::DecodedRow& row, float objective, std::uint32_t paths,
                              const ColoredDecays& decays, const EnergyFactors& energies, void* memory);

}  // namespace tress::fiber
