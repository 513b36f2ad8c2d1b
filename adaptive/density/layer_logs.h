// Logarithms of the knots of a layer, in lanes: what their codes are made of.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "tress/adaptive/ribbon.h"

namespace tress::inline v0_2::adaptive {

/// Where the codes of a knot's values begin.
struct CodeLimits {
  static constexpr double bend = 0.5;  ///< modes are coded by asinh(mode / bend)
  static constexpr double least_attribute = 0.02;
  static constexpr float least_decay = 1e-37f;
};

/// Each array has a value for each knot of a layer. Logarithms have an error below 2.5e-6, attributes one below 5e-7 of
/// their value.
struct LayerLogs {
  template <std::size_t count>
  struct Of {
    std::array<float, count> density;    ///< ln(density / largest of the layer); of 1e-30, if the density is less
    std::array<float, count> mode;       ///< asinh(|mode| / CodeLimits::bend)
    std::array<float, count> below;      ///< ln(max(scale_below, least_scale) / least_scale)
    std::array<float, count> above;      ///< the same of scale_above
    std::array<float, count> attribute;  ///< -ln(decay) / rate, of the first rate
    std::array<float, count> second;     ///< the same of the second rate
    std::array<float, count> logarithm;  ///< ln(max(attribute, least_attribute) / least_attribute)
  };
  static Of<Ribbon::main_knots> of(std::span<const RibbonKnot, Ribbon::main_knots> knots, float largest);
  static Of<Ribbon::broad_knots> of(std::span<const RibbonKnot, Ribbon::broad_knots> knots, float largest);
};

}  // namespace tress::inline v0_2::adaptive
