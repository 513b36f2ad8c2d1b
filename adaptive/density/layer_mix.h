// The mean of layers of knots, in lanes.
#pragma once

#include <cstddef>
#include <span>

#include "tress/adaptive/ribbon.h"

namespace tress::inline v0_2::adaptive {

/// A layer and its share of the mean.
template <std::size_t count>
struct LayerPart {
  const RibbonKnot* knots = nullptr;  ///< `count` of them
  std::size_t shift = 0;              ///< its knot k + shift is paired with knot k of the mean
  float weight = 0;                   ///< those of all layers add up to 1
  float widen = 0;                    ///< ln of a factor on its scales
};

/// Sets all but the azimuths: densities, modes and decays are mixed linearly, scales by their logarithms.
void mix_layers(std::span<const LayerPart<Ribbon::main_knots>> layers, std::span<RibbonKnot, Ribbon::main_knots> mean);
void mix_layers(std::span<const LayerPart<Ribbon::broad_knots>> layers,
                std::span<RibbonKnot, Ribbon::broad_knots> mean);

}  // namespace tress::inline v0_2::adaptive
